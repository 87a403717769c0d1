//! Claim: roots over the particles lower the prediction error of dough.
//!
//! Command: `cargo run --release --bin experiments -- hierarchy`, about ten minutes. Table: `paper/tables/hierarchy.tex`.
use crate::adjudge::{ONE_STEP, ROLLOUT, errs_less};
use crate::claim::{Experiment, Rows, listed, trials};
use pliant::table::{Grid, ablation};
use serde_json::Value;

pub(crate) const CLAIM: Experiment = Experiment {
    name: "hierarchy",
    claim: "roots over the particles lower the prediction error of dough",
    duration: "about 10 minutes",
    rows: Rows::Sweep { config: "configs/sweep/hierarchy.toml", smoke: &["model.learned_roots.train.network.steps=4"] },
    table,
};

fn table(rows: &[Value]) -> anyhow::Result<Grid> {
    let trials = trials(rows)?;
    let mut grid = ablation("Roots over the particles", &trials, name, |_, model| ("baseline", model));
    let pairs = ["8", "16", "16, 4"].map(|roots| [roots, "none"]);
    let judged = [ONE_STEP, ROLLOUT].map(|error| errs_less("roots err less", error, 1.0, &trials, name, &pairs));
    grid.notes.extend(judged);
    Ok(grid)
}

fn name(change: &str) -> String {
    match listed(change) {
        Some(none) if none.is_empty() => "none".to_owned(),
        Some(counts) => counts,
        None => "8".to_owned(),
    }
}
