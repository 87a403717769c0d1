//! Claim: hearing from 2 cm predicts dough better than hearing from 1.3 cm, and as well as from 3 cm.
//!
//! Command: `cargo run --release --bin experiments -- radius`, about 4 minutes. Table: `paper/tables/radius.tex`.
use crate::claim::{Experiment, Rows, changed, trials};
use pliant::table::{Grid, ablation};
use serde_json::Value;

pub(crate) const CLAIM: Experiment = Experiment {
    name: "radius",
    claim: "hearing from 2 cm predicts dough better than hearing from 1.3 cm, and as well as from 3 cm",
    duration: "about 4 minutes",
    rows: Rows::Sweep { config: "configs/sweep/radius.toml", smoke: &["model.learned.train.network.steps=4"] },
    table,
};

fn table(rows: &[Value]) -> anyhow::Result<Grid> {
    Ok(ablation(
        "How far a particle hears [m]",
        &trials(rows)?,
        |change| changed(change, "0.02"),
        |_, model| ("baseline", model),
    ))
}
