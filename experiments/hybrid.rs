//! Claim: a hybrid — written laws and a learned residual — predicts better than the written laws and needs less data than the
//! network alone.
//!
//! Command: `cargo run --release --bin experiments -- hybrid`, about ten minutes. Table: `paper/tables/hybrid.tex`.
use crate::claim::{Experiment, trials};
use pliant::table::{Grid, ablation};
use serde_json::Value;

pub(crate) const CLAIM: Experiment = Experiment {
    name: "hybrid",
    claim: "the hybrid predicts better than both its parents when data are few",
    duration: "about 10 minutes",
    sweep: "configs/sweep/hybrid.toml",
    smoke: &[
        "model.analytic.train.identify.evaluations=12",
        "model.learned.train.network.steps=4",
        "model.hybrid.train.identify.evaluations=12",
        "model.hybrid.train.residual.steps=4",
    ],
    table,
};

fn table(rows: &[Value]) -> anyhow::Result<Grid> {
    Ok(ablation("Hybrid against its parents", &trials(rows)?, name, ("baseline", "hybrid")))
}

fn name(change: &str) -> String {
    change.split_once('=').map_or("all episodes".to_owned(), |(_, n)| format!("{n} episodes"))
}
