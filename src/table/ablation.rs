//! The table of a sweep: one line per change and model.
use super::{Grid, Interval};
use crate::compare::Row;
use indexmap::IndexMap;

/// One row of a sweep: the attempt, and which trial made it.
#[derive(Clone, Debug, PartialEq)]
pub struct TrialRow {
    /// The overrides that lead from the base to the trial, or `baseline`.
    pub change: String,
    /// The attempt.
    pub row: Row,
}

impl TrialRow {
    /// Reads what a sweep collected: a row with the extra field `change`.
    ///
    /// # Errors
    /// When it is not a result row.
    pub fn read(value: &serde_json::Value) -> anyhow::Result<Self> {
        let change = value.get("change").and_then(|c| c.as_str()).unwrap_or("baseline").to_owned();
        Ok(Self { change, row: serde_json::from_value(value.clone())? })
    }
}

/// One line per (change, model): held-out prediction error, achieved cost, and the paired difference to a `reference` line.
///
/// `name` turns a change into what the table calls it; `reference` names the (change, model) that the others are compared
/// with, attempt by attempt (same planner, goal and seed).
pub fn ablation(title: &str, rows: &[TrialRow], name: impl Fn(&str) -> String, reference: (&str, &str)) -> Grid {
    let mut groups: IndexMap<(&str, &str), Vec<&Row>> = IndexMap::new();
    for TrialRow { change, row } in rows {
        groups.entry((change, &row.model)).or_default().push(row);
    }
    let header = ["variant", "model", "one step [mm]", "rollout [mm]", "achieved [mm]", "Δ reference [mm]", "attempts"];
    let base: &[&Row] = groups.get(&reference).map_or(&[], |g| g);
    let line = |(&(change, model), mine): (&(&str, &str), &Vec<&Row>)| {
        let millimetres = |x: Option<f64>| x.map_or("–".to_owned(), |x| format!("{:.2}", 1e3 * x));
        let achieved: Vec<f64> = mine.iter().filter_map(|r| r.achieved).collect();
        let pairs = mine.iter().filter_map(|r| {
            let same = |b: &&&Row| b.planner == r.planner && b.goal == r.goal && b.seed == r.seed;
            Some(r.achieved? - base.iter().find(same)?.achieved?)
        });
        let pairs: Vec<f64> = pairs.collect();
        let delta = if (change, model) == reference { "reference".to_owned() } else { Interval::millimetres(&pairs) };
        vec![
            name(change),
            model.to_owned(),
            millimetres(mine[0].one_step),
            millimetres(mine[0].rollout),
            Interval::millimetres(&achieved),
            delta,
            mine.len().to_string(),
        ]
    };
    let notes = vec![
        "one step, rollout: root mean square error on held-out episodes".to_owned(),
        "Δ reference: achieved cost minus the reference's, paired by goal, planner and seed; negative is better"
            .to_owned(),
    ];
    Grid {
        title: title.to_owned(),
        header: header.map(String::from).to_vec(),
        rows: groups.iter().map(line).collect(),
        notes,
    }
}
