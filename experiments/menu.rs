//! Claims: on dough the graph network predicts and plans better than one code for the whole scene; on a pile that is pushed a linear
//! model of the picture from above does better than the graph network (Suh & Tedrake 2020 found a linear model of images better than
//! deep networks of images).
//!
//! Command: `cargo run --release --bin experiments -- menu`, about 15 minutes. Table: `paper/tables/menu.tex`.
use crate::claim::{Experiment, Rows, trials};
use pliant::table::{Grid, ablation};
use serde_json::Value;

pub(crate) const CLAIM: Experiment = Experiment {
    name: "menu",
    claim: "the graph network beats one code for the whole scene on dough, and a linear model beats it on a pile",
    duration: "about 15 minutes",
    rows: Rows::Sweep {
        config: "configs/sweep/menu.toml",
        smoke: &[
            "model.learned.train.network.steps=4",
            "model.latent.train.latent.steps=4",
            "model.linear.train.picture.steps=4",
            "model.unet.train.picture.steps=4",
        ],
    },
    table,
};

fn table(rows: &[Value]) -> anyhow::Result<Grid> {
    Ok(ablation("Kinds of learned model", &trials(rows)?, name, |change, _| (change, "learned")))
}

fn name(change: &str) -> String {
    if change == "baseline" { "dough" } else { "pile" }.to_owned()
}
