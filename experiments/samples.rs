//! Claim: from 1, 5 and 20 minutes of data the graph network's rollouts err less than those of every other model, written, learned or
//! hybrid.
//!
//! Command: `cargo run --release --bin experiments -- samples`, about fifty minutes. Table: `paper/tables/samples.tex`.
use crate::adjudge::{adjudge, lower};
use crate::claim::{Experiment, Rows, Size};
use crate::transfer::{Duel, Lesson, Model, dataset, duels, judged, lines};
use pliant::table::Grid;
use pliant::watch::Watch;
use serde_json::Value;
use std::path::Path;

pub(crate) const CLAIM: Experiment = Experiment {
    name: "samples",
    claim: "from 1 to 20 minutes of data the graph network errs less over rollouts than every other model",
    duration: "about 50 minutes",
    rows: Rows::Measured(measure),
    table,
};

/// Six hundred steps of a network, and of a code twice as many, as each is smaller; windows are of two control steps, a code's of four.
const MODELS: [Model<'_>; 6] = [
    ("analytic", &[]),
    ("learned", &["train.network.steps=600"]),
    ("hybrid", &[]),
    ("latent", &["train.latent.steps=1200"]),
    ("linear", &["train.picture.steps=600"]),
    ("unet", &["train.picture.steps=600"]),
];
/// Four times the steps, all of them over windows of four control steps, as the code's are anyway.
const LONGER: [Model<'_>; 4] = [
    ("learned", &["train.network.steps=2400", "train.network.horizon=4"]),
    ("latent", &["train.latent.steps=4800"]),
    ("linear", &["train.picture.steps=2400", "train.picture.horizon=4"]),
    ("unet", &["train.picture.steps=2400", "train.picture.horizon=4"]),
];
const SMALL: [Model<'_>; 2] = [("learned", &["train.network.steps=2"]), ("linear", &["train.picture.steps=2"])];
const NETWORK: &str = "learned";
/// Minutes of one tool, of which an episode of fifteen steps takes a fortieth.
const MINUTES: [usize; 3] = [1, 5, 20];

fn measure(size: Size, _: &Path, watch: &Watch) -> anyhow::Result<Vec<Value>> {
    let paper = size == Size::Paper;
    let (name, models, seeds) = if paper { ("quickstart", &MODELS[..], 3) } else { ("smoke", &SMALL[..], 1) };
    // Of a thousand episodes a fifth is held out.
    let words = [if paper { "episodes=1000" } else { "episodes=2" }, "~tool.press_square", "~tool.roller_large"];
    let data = dataset(name, &words, watch)?;
    let mut rows = Vec::new();
    for minutes in MINUTES.into_iter().take(if paper { MINUTES.len() } else { 1 }) {
        rows.extend(judged(models, &Lesson::of(&data, 40 * minutes), &[], seeds, watch)?);
    }
    let longer = if paper { &LONGER[..] } else { &SMALL[..1] };
    for minutes in [MINUTES[0], MINUTES[2]].into_iter().take(if paper { 2 } else { 1 }) {
        let lesson = Lesson::of(&data, 40 * minutes);
        let name = format!("{}, longer", lesson.name());
        rows.extend(judged(longer, &lesson.called(name), &[], seeds, watch)?);
    }
    Ok(rows)
}

fn table(rows: &[Value]) -> anyhow::Result<Grid> {
    let mut grid = lines("Error against minutes of data with the gripper", rows, |model| model == NETWORK);
    let duels = duels(rows, |model| model == NETWORK, |model| model != NETWORK);
    let line = |duel: &Duel<'_>| (format!("{} after {}", duel.theirs, duel.lesson), lower(duel.difference));
    grid.notes
        .push(adjudge("the graph network errs less over rollouts than every other model", duels.iter().map(line)));
    grid.notes.push(
        "longer: four times the steps of training, all of them over windows of four control steps; above, windows are of two, and a \
         code's of four"
            .into(),
    );
    Ok(grid)
}
