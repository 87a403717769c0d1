//! Claim: summed messages predict dough better than averaged ones and than the greatest.
//!
//! Command: `cargo run --release --bin experiments -- aggregation`, about 4 minutes. Table: `paper/tables/aggregation.tex`.
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
    Ok(ablation(
        "How messages become one",
        &trials(rows)?,
        |change| changed(change, "sum"),
        |_, model| ("baseline", model),
    ))
}
