//! Claim: a little noise on the states that training starts from lowers the rollout error, much of it raises it.
//!
//! Command: `cargo run --release --bin experiments -- noise`, about 4 minutes. Table: `paper/tables/noise.tex`.
use crate::claim::{Experiment, Rows, changed, trials};
use pliant::table::{Grid, ablation};
use serde_json::Value;

pub(crate) const CLAIM: Experiment = Experiment {
    name: "noise",
    claim: "a little noise on the states that training starts from lowers the rollout error, much of it raises it",
    duration: "about 4 minutes",
    rows: Rows::Sweep { config: "configs/sweep/noise.toml", smoke: &["model.learned.train.network.steps=4"] },
    table,
};

fn table(rows: &[Value]) -> anyhow::Result<Grid> {
    Ok(ablation(
        "Noise on the states of training [m]",
        &trials(rows)?,
        |change| changed(change, "1e-4"),
        |_, model| ("baseline", model),
    ))
}
