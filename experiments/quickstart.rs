//! Claim: with planner, budget and random numbers equal, every model that plans beats one in which nothing moves, and none
//! beats the simulator itself by more than noise.
//!
//! Command: `cargo run --release --bin experiments -- quickstart`, about five minutes. Table: `paper/tables/quickstart.tex`.
use crate::adjudge::between;
use crate::claim::{Experiment, Rows, SMALL_FITS};
use pliant::table::{Grid, TrialRow, summary};
use serde_json::Value;

pub(crate) const CLAIM: Experiment = Experiment {
    name: "quickstart",
    claim: "every model that plans beats `still`; none beats the simulator by more than noise",
    duration: "about 5 minutes",
    rows: Rows::Sweep { config: "configs/sweep/quickstart.toml", smoke: SMALL_FITS },
    table,
};

fn table(rows: &[Value]) -> anyhow::Result<Grid> {
    let rows = rows.iter().map(|r| Ok(TrialRow::read(r)?.row)).collect::<anyhow::Result<Vec<_>>>()?;
    let mut grid = summary(&rows);
    grid.notes.extend(between(&rows));
    grid.notes.push(
        "oracle is the simulator itself, which also made the goals of hidden actions (pressed, gripped) from the same start: no other \
         model had a hand in its own goal"
            .into(),
    );
    Ok(grid)
}
