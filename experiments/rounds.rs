//! Claim: a second round of message passing lowers the prediction error of dough, a third does not.
//!
//! Command: `cargo run --release --bin experiments -- rounds`, about 4 minutes. Table: `paper/tables/rounds.tex`.
use crate::claim::{Experiment, Rows, changed, trials};
use pliant::table::{Grid, ablation};
use serde_json::Value;

pub(crate) const CLAIM: Experiment = Experiment {
    name: "rounds",
    claim: "a second round of message passing lowers the prediction error of dough, a third does not",
    duration: "about 4 minutes",
    rows: Rows::Sweep { config: "configs/sweep/rounds.toml", smoke: &["model.learned.train.network.steps=4"] },
    table,
};

fn table(rows: &[Value]) -> anyhow::Result<Grid> {
    Ok(ablation(
        "Rounds of message passing",
        &trials(rows)?,
        |change| changed(change, "2"),
        |_, model| ("baseline", model),
    ))
}
