//! Claim: a hybrid — written laws and a learned residual — predicts better than the written laws and needs less data than the
//! network alone.
//!
//! Command: `cargo run --release --bin experiments -- hybrid`, about ten minutes. Table: `paper/tables/hybrid.tex`.
use crate::claim::{Experiment, Rows, SMALL_FITS, trials};
use pliant::table::{Grid, ablation};
use serde_json::Value;

pub(crate) const CLAIM: Experiment = Experiment {
    name: "hybrid",
    claim: "the hybrid predicts better than both its parents when data are few",
    duration: "about 10 minutes",
    rows: Rows::Sweep { config: "configs/sweep/hybrid.toml", smoke: SMALL_FITS },
    table,
};

fn table(rows: &[Value]) -> anyhow::Result<Grid> {
    Ok(ablation("Hybrid against its parents", &trials(rows)?, name, |change, _| (change, "hybrid")))
}

fn name(change: &str) -> String {
    change.split_once('=').map_or("all episodes".to_owned(), |(_, n)| format!("{n} episodes"))
}
