//! Claims: on dough the graph network predicts and plans better than one code for the whole scene; on a pile that is pushed a linear
//! model of the picture from above does better than the graph network (Suh & Tedrake 2020 found a linear model of images better than
//! deep networks of images).
//!
//! Command: `cargo run --release --bin experiments -- menu`, about 15 minutes. Table: `paper/tables/menu.tex`.
use crate::adjudge::{ONE_STEP, ROLLOUT, adjudge, lower, predicted, rows_of};
use crate::claim::{Experiment, Rows, by_planner, trials};
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

/// The scene, who is claimed to do better there, and than whom.
const CLAIMED: [[&str; 3]; 2] = [["dough", "learned", "latent"], ["pile", "linear", "learned"]];

fn table(rows: &[Value]) -> anyhow::Result<Grid> {
    let trials = trials(rows)?;
    let mut grid = ablation("Kinds of learned model", &trials, name, |change, _| (change, "learned"));
    for [scene, mine, other] in CLAIMED {
        let of = |model: &str| rows_of(&trials, |trial| name(&trial.change) == scene && trial.row.model == model);
        let (first, second) = (of(mine), of(other));
        let mut lines: Vec<(String, Option<bool>)> = Vec::new();
        for error in [ONE_STEP, ROLLOUT] {
            lines.push((error.0.to_owned(), lower(predicted(error, 1.0, &first, &second))));
        }
        lines.push(("achieved cost".to_owned(), lower(by_planner(&first, &second))));
        grid.notes.push(adjudge(&format!("{mine} errs and costs less than {other} on the {scene}"), lines));
    }
    Ok(grid)
}

fn name(change: &str) -> String {
    if change == "baseline" { "dough" } else { "pile" }.to_owned()
}
