//! Claim: with two actions, every model achieves more by observing between them than by planning both at once.
//!
//! Command: `cargo run --release --bin experiments -- closed_loop`, about three minutes. Table: `paper/tables/closed_loop.tex`.
use crate::adjudge::{adjudge, lower, rows_of};
use crate::claim::{Experiment, Rows, SMALL_FITS, by_planner, trials};
use indexmap::IndexSet;
use pliant::table::{Grid, ablation};
use serde_json::Value;

pub(crate) const CLAIM: Experiment = Experiment {
    name: "closed_loop",
    claim: "with two actions, observing between them achieves more than planning both at once",
    duration: "about 3 minutes",
    rows: Rows::Sweep { config: "configs/sweep/closed_loop.toml", smoke: SMALL_FITS },
    table,
};

const CLOSED: &str = "closed loop";
const OPEN: &str = "open loop";

/// A model's closed loop is what its open loop is compared with.
fn table(rows: &[Value]) -> anyhow::Result<Grid> {
    let trials = trials(rows)?;
    let mut grid = ablation("Closed against open loop", &trials, name, |_, model| ("baseline", model));
    let models: IndexSet<&str> = trials.iter().map(|trial| trial.row.model.as_str()).collect();
    let line = |model: &&str| {
        let of = |way: &str| rows_of(&trials, |trial| trial.row.model == *model && name(&trial.change) == way);
        ((*model).to_owned(), lower(by_planner(&of(CLOSED), &of(OPEN))))
    };
    grid.notes.push(adjudge("a lower cost in closed than in open loop", models.iter().map(line)));
    Ok(grid)
}

fn name(change: &str) -> String {
    if change == "baseline" { CLOSED.to_owned() } else { OPEN.to_owned() }
}
