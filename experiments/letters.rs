//! Claim: letters of dough come nearer to their goals with a model than without one, and nearest with the simulator.
//!
//! Command: `cargo run --release --bin experiments -- letters`, about twenty minutes. Table: `paper/tables/letters.tex`. The letters
//! as pictures: `gallery.html` in the trial's folder below `runs/sweep`.
use crate::adjudge::between;
use crate::claim::{Experiment, Rows};
use pliant::table::{Grid, TrialRow, summary};
use serde_json::Value;

pub(crate) const CLAIM: Experiment = Experiment {
    name: "letters",
    claim: "every model that plans brings dough nearer to letters than `still`, and the simulator nearest",
    duration: "about 20 minutes",
    rows: Rows::Sweep { config: "configs/sweep/letters.toml", smoke: &["model=[oracle, still]", "actions=1"] },
    table,
};

fn table(rows: &[Value]) -> anyhow::Result<Grid> {
    let rows = rows.iter().map(|r| Ok(TrialRow::read(r)?.row)).collect::<anyhow::Result<Vec<_>>>()?;
    let mut grid = summary(&rows);
    grid.notes.extend(between(&rows));
    Ok(Grid { title: "Letters".into(), ..grid })
}
