//! Claim: a second round of message passing lowers the prediction error of dough; two rounds err at most a tenth more than three.
//!
//! Command: `cargo run --release --bin experiments -- rounds`, about 4 minutes. Table: `paper/tables/rounds.tex`.
use crate::adjudge::{NO_WORSE, ONE_STEP, ROLLOUT, errs_less};
use crate::claim::{Experiment, Rows, changed, trials};
use pliant::table::{Grid, ablation};
use serde_json::Value;

pub(crate) const CLAIM: Experiment = Experiment {
    name: "rounds",
    claim: "a second round of message passing lowers the prediction error of dough, and two err at most a tenth more than three",
    duration: "about 4 minutes",
    rows: Rows::Sweep { config: "configs/sweep/rounds.toml", smoke: &["model.learned.train.network.steps=4"] },
    table,
};

fn table(rows: &[Value]) -> anyhow::Result<Grid> {
    let trials = trials(rows)?;
    let name = |change: &str| changed(change, "2");
    let mut grid = ablation("Rounds of message passing", &trials, name, |_, model| ("baseline", model));
    for error in [ONE_STEP, ROLLOUT] {
        let judged = |what: &str, times, pair| errs_less(what, error, times, &trials, name, &[pair]);
        grid.notes.push(judged("two rounds err less than one", 1.0, ["2", "1"]));
        grid.notes.push(judged(&format!("two rounds err below {NO_WORSE} × three"), NO_WORSE, ["2", "3"]));
    }
    Ok(grid)
}
