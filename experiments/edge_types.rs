//! Claim: each kind of edge lowers the prediction error of a graph network: particle–particle, tool→particle, floor→particle.
//!
//! Command: `cargo run --release --bin experiments -- edge_types`, about three minutes. Table: `paper/tables/edge_types.tex`.
use crate::adjudge::{ONE_STEP, ROLLOUT, errs_less};
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

/// All kinds of edges.
const ALL: &str = "particle, tool, floor";

fn table(rows: &[Value]) -> anyhow::Result<Grid> {
    let trials = trials(rows)?;
    let name = |change: &str| listed(change).unwrap_or_else(|| ALL.to_owned());
    let mut grid = ablation("Edge types", &trials, name, |_, model| ("baseline", model));
    let pairs = ["tool, floor", "particle, floor", "particle, tool"].map(|two| [ALL, two]);
    let judged = [ONE_STEP, ROLLOUT].map(|error| errs_less("all kinds err less", error, 1.0, &trials, name, &pairs));
    grid.notes.extend(judged);
    Ok(grid)
}
