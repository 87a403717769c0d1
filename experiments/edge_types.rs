//! Claim: a graph network needs all three kinds of edges; without the tool's it cannot predict, without the others it predicts
//! worse.
//!
//! Command: `cargo run --release --bin experiments -- edge_types`, about three minutes. Table: `paper/tables/edge_types.tex`.
use crate::claim::{Experiment, Rows, listed, trials};
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
    Ok(ablation(
        "Edge types",
        &trials(rows)?,
        |change| listed(change).unwrap_or_else(|| "particle, tool, floor".to_owned()),
        |_, model| ("baseline", model),
    ))
}
