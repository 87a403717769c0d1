//! Claim: summed messages predict dough better than averaged ones and than the greatest.
//!
//! Command: `cargo run --release --bin experiments -- aggregation`, about 4 minutes. Table: `paper/tables/aggregation.tex`.
use crate::adjudge::{ONE_STEP, ROLLOUT, errs_less};
use crate::claim::{Experiment, Rows, changed, trials};
use pliant::table::{Grid, ablation};
use serde_json::Value;

pub(crate) const CLAIM: Experiment = Experiment {
    name: "aggregation",
    claim: "summed messages predict dough better than averaged ones and than the greatest",
    duration: "about 4 minutes",
    rows: Rows::Sweep { config: "configs/sweep/aggregation.toml", smoke: &["model.learned.train.network.steps=4"] },
    table,
};

fn table(rows: &[Value]) -> anyhow::Result<Grid> {
    let trials = trials(rows)?;
    let name = |change: &str| changed(change, "sum");
    let mut grid = ablation("How messages become one", &trials, name, |_, model| ("baseline", model));
    let pairs = [["sum", "mean"], ["sum", "max"]];
    let judged = [ONE_STEP, ROLLOUT].map(|error| errs_less("sums err less", error, 1.0, &trials, name, &pairs));
    grid.notes.extend(judged);
    Ok(grid)
}
