//! Claim: hybrids — written laws and something learned — predict better than the network alone when data are few, and on materials,
//! tools and sizes that nobody showed them.
//!
//! Command: `cargo run --release --bin experiments -- hybrid`, about fifty minutes. Table: `paper/tables/hybrid.tex`.
use crate::adjudge::{adjudge, lower};
use crate::claim::{Experiment, Rows, Size};
use crate::transfer::{Exam, Lesson, Model, dataset, duels, judged, lines};
use pliant::table::Grid;
use pliant::watch::Watch;
use serde_json::Value;
use std::path::Path;

pub(crate) const CLAIM: Experiment = Experiment {
    name: "hybrid",
    claim: "hybrids predict better than the network alone when data are few, and on unseen materials, tools and sizes",
    duration: "about 50 minutes",
    rows: Rows::Measured(measure),
    table,
};

/// The parents.
const WRITTEN: &str = "analytic";
const NETWORK: &str = "learned";

/// The parents and the hybrids; networks that see everything train for equally many steps.
const MODELS: [Model<'_>; 8] = [
    ("analytic", &[]),
    ("learned", &["train.network.steps=600"]),
    ("hybrid", &[]),
    ("residual", &[]),
    ("output_residual", &[]),
    ("feature", &[]),
    ("projected", &[]),
    ("neural_constants", &[]),
];
/// What makes their fits tiny.
const SMALL: [Model<'_>; 3] = [
    ("analytic", &["train.identify.evaluations=12"]),
    ("learned", &["train.network.steps=2"]),
    ("projected", &["train.projected.steps=2"]),
];
/// Episodes to learn from; who has learned from the last of them is judged on what differs, too.
const LESSONS: [usize; 3] = [9, 27, 72];
/// What differs from the lesson: the dough, the tools, the block, and how often each tool is used.
const UNSEEN: [(&str, &[&str]); 4] = [
    ("clay", &["scene.material=clay"]),
    ("play_doh", &["scene.material=play_doh"]),
    (
        "other tools",
        &[
            "tool=[gripper_plane,punch_square]",
            "tool.gripper_plane.width=[0.02,0.04]",
            "tool.punch_square.lowest=0.012",
        ],
    ),
    ("a larger block", &["scene.start.x=[0.0651,0.0749]", "scene.start.y=[0.0651,0.0749]", "scene.particles=256"]),
];

fn measure(size: Size, _: &Path, watch: &Watch) -> anyhow::Result<Vec<Value>> {
    let paper = size == Size::Paper;
    let (name, models, seeds) = if paper { ("quickstart", &MODELS[..], 5) } else { ("smoke", &SMALL[..], 1) };
    let data = dataset(name, &[], watch)?;
    let exams = UNSEEN.iter().map(|(what, words)| {
        let drawn = ["seed=2", if paper { "episodes=24" } else { "episodes=2" }];
        Ok(Exam::of(*what, dataset(name, &[*words, &drawn].concat(), watch)?))
    });
    let exams = exams.collect::<anyhow::Result<Vec<_>>>()?;
    let lessons = if paper { &LESSONS[..] } else { &LESSONS[..1] };
    let mut rows = Vec::new();
    for (k, count) in lessons.iter().enumerate() {
        let exams = if k + 1 == lessons.len() { &exams[..] } else { &[] };
        rows.extend(judged(models, &Lesson::of(&data, *count), exams, seeds, watch)?);
    }
    Ok(rows)
}

fn table(rows: &[Value]) -> anyhow::Result<Grid> {
    let mut grid = lines("Hybrids against their parents", rows, |model| model == NETWORK);
    let duels = duels(rows, |model| ![WRITTEN, NETWORK].contains(&model), |model| model == NETWORK);
    // The first lesson is the shortest.
    let few = rows.first().and_then(|row| row["lesson"].as_str()).unwrap_or("–");
    let least = duels.iter().filter(|duel| duel.lesson == few && duel.exam == "the same");
    let least = least.map(|duel| (duel.mine.to_owned(), lower(duel.difference)));
    grid.notes.push(adjudge(&format!("hybrids err less over rollouts than the network after {few}"), least));
    let unseen = duels.iter().filter(|duel| duel.exam != "the same");
    let unseen = unseen.map(|duel| (format!("{} on {}", duel.mine, duel.exam), lower(duel.difference)));
    grid.notes.push(adjudge("hybrids err less over rollouts than the network on what nobody showed them", unseen));
    Ok(grid)
}
