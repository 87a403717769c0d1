//! Claim: observing between actions helps every imperfect model.
//!
//! Command: `cargo run --release --bin experiments -- closed_loop`, about six minutes. Table: `paper/tables/closed_loop.tex`.
use crate::claim::{Experiment, trials};
use pliant::table::{Grid, TrialRow, ablation};
use serde_json::Value;

pub(crate) const CLAIM: Experiment = Experiment {
    name: "closed_loop",
    claim: "with two actions, observing between them achieves more than planning both at once",
    duration: "about 6 minutes",
    sweep: "configs/sweep/closed_loop.toml",
    smoke: &[
        "model.analytic.train.identify.evaluations=12",
        "model.learned.train.network.steps=4",
        "model.hybrid.train.identify.evaluations=12",
        "model.hybrid.train.residual.steps=4",
    ],
    table,
};

/// One block a model: its closed loop is what its open loop is compared with.
fn table(rows: &[Value]) -> anyhow::Result<Grid> {
    let rows = trials(rows)?;
    let mut models: Vec<&str> = Vec::new();
    rows.iter().for_each(|r| {
        if !models.contains(&r.row.model.as_str()) {
            models.push(&r.row.model)
        }
    });
    let blocks = models.iter().map(|model| {
        let mine: Vec<TrialRow> = rows.iter().filter(|r| r.row.model == *model).cloned().collect();
        ablation("Closed against open loop", &mine, name, ("baseline", model))
    });
    let whole = blocks.reduce(|mut all, block| {
        all.rows.extend(block.rows);
        all
    });
    Ok(whole.unwrap_or_default())
}

fn name(change: &str) -> String {
    if change == "baseline" { "closed loop".to_owned() } else { "open loop".to_owned() }
}
