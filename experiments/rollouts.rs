//! Claim: in every kind of scene a graph network's rollout errs less than a model in which nothing moves.
//!
//! Command: `cargo run --release --bin experiments -- rollouts`, about ten minutes. Table: `paper/tables/rollouts.tex`; pictures:
//! `paper/figures/rollouts.png`, an unseen episode of each scene as the simulator has it and, below it, as the network predicts it.
use crate::adjudge::adjudge;
use crate::claim::{Experiment, Rows, Size, number};
use crate::film::film;
use crate::transfer::{Lesson, Model, dataset};
use anyhow::Context;
use pliant::config::write_whole;
use pliant::table::{Grid, sheet};
use pliant::watch::Watch;
use serde_json::{Value, json};
use std::path::Path;

pub(crate) const CLAIM: Experiment = Experiment {
    name: "rollouts",
    claim: "in every kind of scene the graph network's rollout errs less than a model in which nothing moves",
    duration: "about 10 minutes",
    rows: Rows::Measured(measure),
    table,
};

/// Datasets, each with the graph network that takes it.
const SCENES: [(&str, Model<'_>); 6] = [
    ("quickstart", ("learned", &["train.network.steps=600"])),
    ("pile_push", ("learned", &["train.network.steps=600"])),
    ("slide", ("learned", &["train.network.steps=600", "+dynamics.rigid=[0]"])),
    ("fluid_fall", ("fluid", &["train.network.steps=600"])),
    ("fluid_shake", ("fluid", &["train.network.steps=600"])),
    ("box_bath", ("fluid", &["train.network.steps=400", "+dynamics.rigid=[1]", "+dynamics.laws.0.bodies=2"])),
];
const SMALL: [(&str, Model<'_>); 1] = [("smoke", ("learned", &["train.network.steps=2"]))];

fn measure(size: Size, out: &Path, watch: &Watch) -> anyhow::Result<Vec<Value>> {
    let (mut rows, mut strips) = (Vec::new(), Vec::new());
    for (name, model) in if size == Size::Paper { &SCENES[..] } else { &SMALL[..] } {
        let lesson = Lesson::of(&dataset(name, &[], watch)?, usize::MAX);
        let fitted = lesson.teach(model, 0, watch)?;
        let (episode, shape) = lesson.unseen();
        let predicted = fitted.model.rollout(&episode.scene(0, shape), &episode.controls);
        let told = fitted.held_out.with_context(|| format!("{name} has no recorded start"))?;
        rows.push(json!({ "scene": name, "model": model.0, "particles": episode.states[0].len(),
            "steps": episode.horizon(), "one_step": told.one_step, "rollout": told.rollout,
            "still_rollout": told.still_rollout, "not_finite": told.not_finite, "episodes": told.episodes }));
        strips.push(film(&format!("{name}: the simulator"), episode, shape, &episode.states));
        strips.push(film(&format!("{name}: the network"), episode, shape, &predicted));
    }
    write_whole(&out.join("figures/rollouts.png"), &sheet(&strips)?)?;
    Ok(rows)
}

fn table(rows: &[Value]) -> anyhow::Result<Grid> {
    let share = |row: &Value| number(row, "rollout") / number(row, "still_rollout");
    let line = |row: &Value| {
        let text = |key: &str| row[key].as_str().unwrap_or("–").to_owned();
        let mut cells = vec![text("scene"), text("model")];
        cells.extend(["particles", "steps", "episodes"].map(|key| row[key].to_string()));
        cells.extend(["one_step", "rollout", "still_rollout"].map(|key| format!("{:.2}", 1e3 * number(row, key))));
        cells.push(format!("{:.2}", share(row)));
        cells
    };
    let less = rows.iter().filter(|row| share(row) < 1.0).count();
    // One fit has no interval: it can refute that all err less, not show it.
    let told = |row: &Value| (row["scene"].as_str().unwrap_or("–").to_owned(), (share(row) >= 1.0).then_some(false));
    let claim = adjudge("a rollout error below that of nothing moving", rows.iter().map(told));
    let header =
        ["scene", "model", "particles", "steps", "episodes", "one step [mm]", "rollout [mm]", "still [mm]", "÷ still"];
    Ok(Grid {
        title: "Rollouts of every kind of scene".into(),
        header: header.map(String::from).to_vec(),
        rows: rows.iter().map(line).collect(),
        notes: vec![
            "root mean square error over particles and held-out episodes, one fit a scene; figures/rollouts.png shows the first \
             such episode of each"
                .into(),
            format!("the one fit errs less than where nothing moves in {less} of {} scenes, but has no interval over fits", rows.len()),
            claim,
        ],
    })
}
