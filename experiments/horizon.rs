//! Claim: training on two steps lowers the rollout error against one, and four against two.
//!
//! Command: `cargo run --release --bin experiments -- horizon`, about 4 minutes. Table: `paper/tables/horizon.tex`.
use crate::adjudge::{ROLLOUT, errs_less};
use crate::claim::{Experiment, Rows, changed, trials};
use pliant::table::{Grid, ablation};
use serde_json::Value;

pub(crate) const CLAIM: Experiment = Experiment {
    name: "horizon",
    claim: "training on two steps lowers the rollout error against one, and four against two",
    duration: "about 4 minutes",
    rows: Rows::Sweep { config: "configs/sweep/horizon.toml", smoke: &["model.learned.train.network.steps=4"] },
    table,
};

fn table(rows: &[Value]) -> anyhow::Result<Grid> {
    let trials = trials(rows)?;
    let name = |change: &str| changed(change, "2");
    let mut grid = ablation("Steps that training rolls out", &trials, name, |_, model| ("baseline", model));
    let pairs = [["2", "1"], ["4", "2"]];
    grid.notes.push(errs_less("more steps err less", ROLLOUT, 1.0, &trials, name, &pairs));
    Ok(grid)
}
