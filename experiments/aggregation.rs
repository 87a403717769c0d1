//! Claim: messages that are summed predict better than their mean or their maximum.
//!
//! Command: `cargo run --release --bin experiments -- aggregation`, about DURATION. Table: `paper/tables/aggregation.tex`.
use crate::claim::{Experiment, Rows, trials};
use pliant::table::{Grid, ablation};
use serde_json::Value;

pub(crate) const CLAIM: Experiment = Experiment {
    name: "aggregation",
    claim: "messages that are summed predict better than their mean or their maximum",
    duration: "about DURATION",
    rows: Rows::Sweep { config: "configs/sweep/aggregation.toml", smoke: &["model.learned.train.network.steps=4"] },
    table,
};

fn table(rows: &[Value]) -> anyhow::Result<Grid> {
    let name = |change: &str| change.rsplit_once('=').map_or("sum", |(_, kind)| kind).to_owned();
    Ok(ablation("Aggregation of messages", &trials(rows)?, name, |_, model| ("baseline", model)))
}
