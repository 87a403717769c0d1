//! Claim: more rounds of message passing lower the prediction error of dough.
//!
//! Command: `cargo run --release --bin experiments -- rounds`, about DURATION. Table: `paper/tables/rounds.tex`.
use crate::claim::{Experiment, Rows, trials};
use pliant::table::{Grid, ablation};
use serde_json::Value;

pub(crate) const CLAIM: Experiment = Experiment {
    name: "rounds",
    claim: "more rounds of message passing lower the prediction error of dough",
    duration: "about DURATION",
    rows: Rows::Sweep { config: "configs/sweep/rounds.toml", smoke: &["model.learned.train.network.steps=4"] },
    table,
};

fn table(rows: &[Value]) -> anyhow::Result<Grid> {
    let name = |change: &str| change.rsplit_once('=').map_or("2", |(_, rounds)| rounds).to_owned();
    Ok(ablation("Rounds of message passing", &trials(rows)?, name, |_, model| ("baseline", model)))
}
