//! Claim: products in bfloat16 change the graph network's rollout error by less than the standard deviation of its fits.
//!
//! Command: `cargo run --release --bin experiments -- rounding`, about ten minutes. Table: `paper/tables/rounding.tex`.
use crate::adjudge::adjudge;
use crate::claim::{Experiment, Rows, Size};
use crate::transfer::{Lesson, Model, dataset, duels, judged, lines};
use pliant::table::{Grid, Interval};
use pliant::watch::Watch;
use serde_json::Value;
use statrs::statistics::Statistics;
use std::path::Path;

pub(crate) const CLAIM: Experiment = Experiment {
    name: "rounding",
    claim: "predicting in bfloat16 changes the graph network's rollout error by less than its fits differ",
    duration: "about 10 minutes",
    rows: Rows::Measured(measure),
    table,
};

const MODELS: [Model<'_>; 2] =
    [("learned", &["train.network.steps=600"]), ("learned_bfloat16", &["train.network.steps=600"])];
const SMALL: [Model<'_>; 2] =
    [("learned", &["train.network.steps=2"]), ("learned_bfloat16", &["train.network.steps=2"])];

fn measure(size: Size, _: &Path, watch: &Watch) -> anyhow::Result<Vec<Value>> {
    let (name, models, seeds) = match size {
        Size::Paper => ("quickstart", MODELS, 5),
        Size::Smoke => ("smoke", SMALL, 1),
    };
    judged(&models, &Lesson::of(&dataset(name, &[], watch)?, usize::MAX), &[], seeds, watch)
}

fn table(rows: &[Value]) -> anyhow::Result<Grid> {
    let mut grid = lines("Predictions in bfloat16", rows, |model| model == "learned");
    let fits = rows.iter().filter(|row| row["model"] == "learned").filter_map(|row| row["rollout"].as_f64());
    let spread = fits.collect::<Vec<_>>().std_dev();
    let claims = duels(rows, |model| model != "learned", |model| model == "learned");
    let within = |Interval { mean, half, .. }: Interval| {
        let (nearest, farthest) = ((mean.abs() - half).max(0.0), mean.abs() + half);
        if farthest < spread { Some(true) } else { (nearest > spread).then_some(false) }
    };
    let claims = claims.iter().map(|duel| (duel.mine.to_owned(), duel.difference.and_then(within)));
    let what = format!("a change of the rollout error below {:.2} mm, the standard deviation of fits", 1e3 * spread);
    grid.notes.push(adjudge(&what, claims));
    Ok(grid)
}
