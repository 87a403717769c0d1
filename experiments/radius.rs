//! Claim: hearing from 2 cm predicts dough better than hearing from 1.3 cm, and errs at most a tenth more than from 3 cm.
//!
//! Command: `cargo run --release --bin experiments -- radius`, about 4 minutes. Table: `paper/tables/radius.tex`.
use crate::adjudge::{NO_WORSE, ONE_STEP, ROLLOUT, errs_less};
use crate::claim::{Experiment, Rows, changed, trials};
use pliant::table::{Grid, ablation};
use serde_json::Value;

pub(crate) const CLAIM: Experiment = Experiment {
    name: "radius",
    claim: "hearing from 2 cm predicts dough better than hearing from 1.3 cm, and errs at most a tenth more than from 3 cm",
    duration: "about 4 minutes",
    rows: Rows::Sweep { config: "configs/sweep/radius.toml", smoke: &["model.learned.train.network.steps=4"] },
    table,
};

fn table(rows: &[Value]) -> anyhow::Result<Grid> {
    let trials = trials(rows)?;
    let name = |change: &str| changed(change, "0.02");
    let mut grid = ablation("How far a particle hears [m]", &trials, name, |_, model| ("baseline", model));
    for error in [ONE_STEP, ROLLOUT] {
        let judged = |what: &str, times, pair| errs_less(what, error, times, &trials, name, &[pair]);
        grid.notes.push(judged("from 2 cm errs less than from 1.3 cm", 1.0, ["0.02", "0.013"]));
        grid.notes.push(judged(&format!("from 2 cm errs below {NO_WORSE} × from 3 cm"), NO_WORSE, ["0.02", "0.03"]));
    }
    Ok(grid)
}
