//! Claim: products in bfloat16 leave the graph network's error of prediction where it is.
//!
//! Command: `cargo run --release --bin experiments -- rounding`, about ten minutes. Table: `paper/tables/rounding.tex`.
use crate::claim::{Experiment, Rows, Size};
use crate::transfer::{Lesson, Model, dataset, judged, lines};
use pliant::table::Grid;
use pliant::watch::Watch;
use serde_json::Value;
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
    Ok(lines("Predictions in bfloat16", rows, |model| model == "learned"))
}
