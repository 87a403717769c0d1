//! Claim: a graph network needs all three kinds of edges; without the tool's it cannot predict, without the others it predicts
//! worse.
//!
//! Command: `cargo run --release --bin experiments -- edge_types`, about three minutes. Table: `paper/tables/edge_types.tex`.
use crate::claim::{Experiment, Rows, trials};
use pliant::table::{Grid, ablation};
use serde_json::Value;

pub(crate) const CLAIM: Experiment = Experiment {
    name: "edge_types",
    claim: "each kind of edge lowers the prediction error: particle–particle, tool→particle, floor→particle",
    duration: "about 3 minutes",
    rows: Rows::Sweep { config: "configs/sweep/edge_types.toml", smoke: &["model.learned.train.network.steps=4"] },
    table,
};

fn table(rows: &[Value]) -> anyhow::Result<Grid> {
    Ok(ablation("Edge types", &trials(rows)?, name, |_, model| ("baseline", model)))
}

/// `model.learned.dynamics.laws.0.edges=["tool", "floor"]` → `tool, floor`.
fn name(change: &str) -> String {
    match change.split_once('=') {
        Some((_, list)) => list.replace(['[', ']', '"', '\''], "").replace(',', ", ").replace("  ", " "),
        None => "particle, tool, floor".to_owned(),
    }
}
