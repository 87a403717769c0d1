//! Claim: trained on scenes of few particles, the graph network predicts scenes of up to ten times as many better than one code for
//! the whole scene and than models of its picture, in grains, in water and in dough.
//!
//! Command: `cargo run --release --bin experiments -- generalise`, about half an hour. Table: `paper/tables/generalise.tex`.
use crate::adjudge::{adjudge, lower};
use crate::claim::{Experiment, Rows, Size};
use crate::transfer::{Duel, Exam, Lesson, Model, dataset, duels, judged, lines};
use pliant::table::Grid;
use pliant::watch::Watch;
use serde_json::Value;
use std::path::Path;

pub(crate) const CLAIM: Experiment = Experiment {
    name: "generalise",
    claim: "trained on few particles, the graph network predicts more of them better than a code or a picture does",
    duration: "about 30 minutes",
    rows: Rows::Measured(measure),
    table,
};

/// A kind of scene: its dataset, what is common to all its sizes, the sizes, and the graph network that it takes.
struct Scenes {
    name: &'static str,
    dataset: &'static str,
    words: &'static [&'static str],
    /// Particles, and the start that holds them; the first is learned from.
    sizes: &'static [(usize, &'static [&'static str])],
    graph: Model<'static>,
}

const SCENES: [Scenes; 3] = [
    Scenes {
        name: "grains",
        dataset: "pile_push",
        words: &["scene.start.z=[0.03,0.03]"],
        sizes: &[
            (5, &["scene.start.x=[0.025,0.03]", "scene.start.y=[0.025,0.03]"]),
            (10, &["scene.start.x=[0.03,0.04]", "scene.start.y=[0.03,0.04]"]),
            (20, &["scene.start.x=[0.035,0.05]", "scene.start.y=[0.035,0.05]"]),
            (50, &["scene.start.x=[0.045,0.07]", "scene.start.y=[0.045,0.07]"]),
        ],
        graph: ("learned", &["train.network.steps=600"]),
    },
    Scenes {
        name: "water",
        dataset: "fluid_fall",
        words: &[],
        sizes: &[(200, &["scene.start.radius=[0.03,0.03]"]), (400, &["scene.start.radius=[0.0378,0.0378]"])],
        graph: ("fluid", &["train.network.steps=600"]),
    },
    Scenes {
        name: "dough",
        dataset: "robocook",
        words: &["tool=[gripper_rod,press_square]", "scene.solver.sweeps=2"],
        sizes: &[
            (300, &["scene.start={kind=block,x=[0.0541,0.0599],y=[0.0541,0.0599],z=[0.0241,0.0299],turn=[0.0,0.0]}"]),
            (600, &["scene.start={kind=block,x=[0.0661,0.0719],y=[0.0661,0.0719],z=[0.0301,0.0359],turn=[0.0,0.0]}"]),
            (1200, &["scene.start={kind=block,x=[0.0841,0.0899],y=[0.0901,0.0959],z=[0.0361,0.0419],turn=[0.0,0.0]}"]),
        ],
        graph: ("learned", &["train.network.steps=600", "dynamics.graph.radius=0.012", "dynamics.laws.0.radius=0.012"]),
    },
];

/// The other models, tuned for scenes of the first size like the network.
const OTHERS: [Model<'_>; 3] = [
    ("latent", &["train.latent.steps=1200"]),
    ("linear", &["train.picture.steps=600"]),
    ("unet", &["train.picture.steps=600"]),
];
const SMALL: [Model<'_>; 2] = [("learned", &["train.network.steps=2"]), ("linear", &["train.picture.steps=2"])];

fn measure(size: Size, _: &Path, watch: &Watch) -> anyhow::Result<Vec<Value>> {
    let paper = size == Size::Paper;
    let mut rows = Vec::new();
    for scenes in SCENES.iter().take(if paper { SCENES.len() } else { 1 }) {
        let drawn = |k: usize, episodes: usize, seed: u64| {
            let (particles, start) = scenes.sizes[k];
            let own = [format!("episodes={episodes}"), format!("seed={seed}"), format!("scene.particles={particles}")];
            let own: Vec<&str> = own.iter().map(String::as_str).collect();
            dataset(scenes.dataset, &[scenes.words, start, &own].concat(), watch)
        };
        let (models, seeds, learned_from, judged_on) = match paper {
            true => ([&[scenes.graph], &OTHERS[..]].concat(), 3, 60, 12),
            false => (SMALL.to_vec(), 1, 4, 1),
        };
        let first = scenes.sizes[0].0;
        let lesson = Lesson::of(&drawn(0, learned_from, 1)?, usize::MAX).called(format!("{first} of {}", scenes.name));
        let mut exams = Vec::new();
        for k in 1..if paper { scenes.sizes.len() } else { 2 } {
            exams.push(Exam::of(scenes.sizes[k].0.to_string(), drawn(k, judged_on, 2)?));
        }
        rows.extend(judged(&models, &lesson, &exams, seeds, watch)?);
    }
    Ok(rows)
}

fn table(rows: &[Value]) -> anyhow::Result<Grid> {
    let graph = |model: &str| SCENES.iter().any(|scenes| scenes.graph.0 == model);
    let mut grid = lines("Trained on few particles, judged on more", rows, graph);
    let duels = duels(rows, graph, |model| !graph(model));
    let more = duels.iter().filter(|duel| duel.exam != "the same");
    let line =
        |duel: &Duel<'_>| (format!("{}, {} against {}", duel.lesson, duel.exam, duel.theirs), lower(duel.difference));
    grid.notes.push(adjudge("the graph network errs less over rollouts of more particles", more.map(line)));
    Ok(grid)
}
