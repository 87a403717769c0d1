//! One line of the results: one model, one planner, one goal, one seed.
use super::ControlSpec;
use crate::metric::Column;
use anyhow::Context;
use indexmap::IndexMap;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// What one attempt promised, achieved and spent. Fields that do not apply are null.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Model name, its config's file stem.
    pub model: String,
    /// Planner name.
    pub planner: String,
    /// Goal name.
    pub goal: String,
    /// Seed of the start and of every random stream.
    pub seed: u64,
    /// Whether the world was observed between actions (`closed`), only before the first (`open`), or to check plans (`triggered`).
    pub control: ControlSpec,
    /// Plans made, where an action need not have one of its own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub plans: Option<usize>,
    /// Tools used, in order.
    pub tools: Vec<String>,
    /// Actions executed θ, in order.
    pub actions: Vec<Vec<f64>>,
    /// Cost that the model promised for the last action; null when the planner found no plan.
    pub predicted: Option<f64>,
    /// Cost of what the world made of the plan, or of the start where that was near enough to the goal; null without either.
    pub achieved: Option<f64>,
    /// Cost before the first action.
    pub start: f64,
    /// The model's error one step ahead on held-out episodes, root mean square \[m\]; null for the simulator.
    pub one_step: Option<f64>,
    /// The same for the last state of whole rollouts \[m\].
    pub rollout: Option<f64>,
    /// Every metric of the achieved shape against the goal, by name; null where it is not defined.
    pub metrics: IndexMap<String, Option<f64>>,
    /// How the numbers of those metrics are read that are not always reported, by name.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub columns: IndexMap<String, Column>,
    /// Every metric between two samplings of the goal, what a perfect model would score; empty where the goal is matched.
    pub floors: IndexMap<String, Option<f64>>,
    /// Model rollouts spent planning.
    pub rollouts: usize,
    /// Gradients spent planning.
    pub gradients: usize,
    /// Rollouts that were not finite.
    pub not_finite: usize,
    /// Wall seconds spent planning.
    pub seconds: f64,
    /// Commit of the code that made this row, empty outside a checkout.
    pub commit: String,
    /// Fingerprint of the resolved config that made this row.
    pub fingerprint: String,
}

/// Reads a `rows.jsonl`; an absent file holds no rows.
///
/// # Errors
/// Names the file and line that is not a row.
pub fn read_rows(path: &Path) -> anyhow::Result<Vec<Row>> {
    if !path.exists() {
        return Ok(Vec::new());
    }
    let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    let parse = |(number, line)| {
        serde_json::from_str(line).with_context(|| {
            let place = format!("{}:{}", path.display(), number + 1);
            format!("{place} is not a result row; delete that line, its attempt will be run again")
        })
    };
    text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()).map(parse).collect()
}

/// The rows as JSON lines.
pub fn to_jsonl(rows: &[Row]) -> String {
    rows.iter().map(|row| serde_json::to_string(row).expect("rows hold only numbers and text") + "\n").collect()
}
