//! Claim: observing between actions helps every imperfect model.
//!
//! Command: `cargo run --release --bin experiments -- closed_loop`, about three minutes. Table: `paper/tables/closed_loop.tex`.
use crate::claim::{Experiment, Rows, SMALL_FITS, trials};
use pliant::table::{Grid, ablation};
use serde_json::Value;

pub(crate) const CLAIM: Experiment = Experiment {
    name: "closed_loop",
    claim: "with two actions, observing between them achieves more than planning both at once",
    duration: "about 3 minutes",
    rows: Rows::Sweep { config: "configs/sweep/closed_loop.toml", smoke: SMALL_FITS },
    table,
};

/// A model's closed loop is what its open loop is compared with.
fn table(rows: &[Value]) -> anyhow::Result<Grid> {
    Ok(ablation("Closed against open loop", &trials(rows)?, name, |_, model| ("baseline", model)))
}

fn name(change: &str) -> String {
    if change == "baseline" { "closed loop".to_owned() } else { "open loop".to_owned() }
}
