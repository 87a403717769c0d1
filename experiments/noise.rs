//! Claim: against none, a little noise on the states that training starts from lowers the rollout error, and much of it raises it.
//!
//! Command: `cargo run --release --bin experiments -- noise`, about 4 minutes. Table: `paper/tables/noise.tex`.
use crate::adjudge::{ROLLOUT, errs_less};
use crate::claim::{Experiment, Rows, changed, trials};
use pliant::table::{Grid, ablation};
use serde_json::Value;

pub(crate) const CLAIM: Experiment = Experiment {
    name: "noise",
    claim: "against none, a little noise on the states that training starts from lowers the rollout error, and much of it raises it",
    duration: "about 4 minutes",
    rows: Rows::Sweep { config: "configs/sweep/noise.toml", smoke: &["model.learned.train.network.steps=4"] },
    table,
};

fn table(rows: &[Value]) -> anyhow::Result<Grid> {
    let trials = trials(rows)?;
    let name = |change: &str| changed(change, "1e-4");
    let mut grid = ablation("Noise on the states of training [m]", &trials, name, |_, model| ("baseline", model));
    let judged = |what: &str, pair| errs_less(what, ROLLOUT, 1.0, &trials, name, &[pair]);
    grid.notes.push(judged("a little noise errs less than none", ["1e-4", "0.0"]));
    grid.notes.push(judged("none errs less than much", ["0.0", "1e-3"]));
    Ok(grid)
}
