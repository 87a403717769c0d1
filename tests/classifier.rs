//! Choosers that learn, draw or are told which tool to plan.
mod drag;

use drag::*;
use glam::DVec3;
use indexmap::IndexMap;
use pliant::chooser::{Chooser, ChooserSpec, Exhaustive, Lesson, Task};
use pliant::config::fingerprint;
use pliant::data::Episode;
use pliant::problem::Budget;
use pliant::state::*;
use pliant::tool::Tool;
use pliant::train::Split;
use pliant::train::classifier::{Classifier, REPORT, Report};
use pliant::train::point_net::PointNetSpec;
use pliant::watch::Watch;
use rand::Rng;
use rand::seq::SliceRandom;
use std::path::Path;

/// What tools do: flatten, carry away, nothing.
const TOOLS: [&str; 3] = ["press", "pusher", "none"];

fn lump(seed: u64) -> Vec<DVec3> {
    let mut rng = stream(seed, &[1]);
    let mut axis = |half: f64| rng.random_range(-half..half);
    (0..24).map(|_| DVec3::new(axis(0.05), axis(0.05), 0.02 + axis(0.02))).collect()
}

fn after(tool: usize, seed: u64) -> Vec<DVec3> {
    let amount = stream(seed, &[2]).random_range(0.5..1.0);
    let act = |p: DVec3| match tool {
        0 => p.with_z(p.z * (1.0 - 0.8 * amount)),
        1 => p + DVec3::new(0.04 * amount, 0.0, 0.0),
        _ => p,
    };
    lump(seed).into_iter().map(act).collect()
}

fn episodes(seeds: std::ops::Range<u64>) -> Vec<Episode> {
    let one = |seed: u64| {
        let tool = seed as usize % TOOLS.len();
        Episode {
            tool: TOOLS[tool].to_owned(),
            theta: Vec::new(),
            interval: 0.1,
            start: Vec::new(),
            controls: Vec::new(),
            states: [lump(seed), after(tool, seed)].map(Particles::at_rest).to_vec(),
            body: [0; 24].into(),
            walls: [].into(),
            constants: Default::default(),
        }
    };
    seeds.map(one).collect()
}

fn split() -> Split {
    let shape = slide(0.03).shape().clone();
    let tools = TOOLS.iter().map(|tool| ((*tool).to_owned(), shape.clone())).collect();
    Split { train: episodes(0..60), held_out: episodes(60..90), tools }
}

fn network(steps: u64) -> PointNetSpec {
    PointNetSpec { width: 16, steps, batch: 16, log_every: 20, ..PointNetSpec::default() }
}

fn tools() -> IndexMap<String, Box<dyn Tool>> {
    TOOLS.iter().map(|name| ((*name).to_owned(), Box::new(slide(0.03)) as Box<dyn Tool>)).collect()
}

/// The chooser of a config, made of these episodes below `root`.
fn made(text: &str, root: &Path) -> anyhow::Result<Box<dyn Chooser>> {
    let spec: ChooserSpec = toml_edit::de::from_str(text)?;
    let (data, tools, watch) = (split(), tools(), Watch::silent());
    let lesson = Lesson { data: &data, dataset: &fingerprint(&1), tools: &tools, root, watch: &watch };
    spec.build()?.make(&lesson)
}

/// What a chooser would plan for seed and action, from a lump to what tool number `tool` makes of it.
fn shortlist(chooser: &dyn Chooser, tool: usize, seed: u64, action: u64) -> Vec<usize> {
    let (current, goal_points, cem) = (lump(500), after(tool, 500), planner("cem"));
    let task = Task {
        model: &Drag,
        tools: &tools(),
        scene: &scene,
        piece: piece(),
        cost: &cost("chamfer", goal(0.03, &[0.01, -0.01, 1.0])),
        current: &current,
        goal: &goal_points,
        policies: &IndexMap::new(),
        steps: 6,
        planner: cem.as_ref(),
        budget: Budget { rollouts: 1, ..BUDGET },
        clock: &|| 0.0,
        seed,
        action,
        lookahead: 1,
    };
    chooser.shortlist(&task)
}

#[test]
fn tools_that_leave_different_shapes_are_told_apart_on_shapes_that_were_never_seen() {
    let folder = tempfile::tempdir().unwrap();
    let classifier = Classifier::fit(&network(300), &split(), folder.path(), &Watch::silent()).unwrap();
    let report: Report = serde_json::from_slice(&std::fs::read(folder.path().join(REPORT)).unwrap()).unwrap();
    assert_eq!(report.episodes, 30);
    assert!(report.top_1 > 0.9 && report.top_3 == 1.0, "{report:?}");
    let right: usize = (0..3).map(|k| report.confusion[k][k]).sum();
    assert!((right as f64 / 30.0 - report.top_1).abs() < 1e-12);
    assert_eq!(report, classifier.judged(&episodes(60..90)).unwrap());
    for seed in 0..9 {
        let (from, to) = (lump(seed), after(seed as usize % 3, seed));
        let probabilities = classifier.probabilities(&from, &to);
        assert!((probabilities.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{probabilities:?}");
        let shuffled = |cloud: &[DVec3]| {
            let mut cloud = cloud.to_vec();
            cloud.shuffle(&mut stream(seed, &[4]));
            cloud
        };
        assert_eq!(classifier.probabilities(&shuffled(&from), &shuffled(&to)), probabilities, "bit for bit");
    }
}

#[test]
fn the_shortlist_holds_the_likely_tools_and_all_of_them_where_all_are_asked_for() {
    let root = tempfile::tempdir().unwrap();
    let small = "network = { width = 16, steps = 300, batch = 16 }";
    let config = |top: usize, above: f64| format!("kind = 'classifier'\ntop = {top}\nabove = {above:?}\n{small}");
    let likely = made(&config(1, 0.0), root.path()).unwrap();
    let everything = made(&config(3, 0.0), root.path()).unwrap();
    let sure = made(&config(3, 1.0), root.path()).unwrap();
    for tool in 0..3 {
        assert_eq!(shortlist(likely.as_ref(), tool, 0, 0), [tool]);
        assert_eq!(shortlist(everything.as_ref(), tool, 0, 0), shortlist(&Exhaustive, tool, 0, 0));
        assert_eq!(shortlist(sure.as_ref(), tool, 0, 0), [tool], "the most probable one whatever its probability");
    }
    let folder = likely.folder().unwrap();
    assert!(folder.starts_with(root.path()) && folder.join(REPORT).exists() && folder.join("recipe.json").exists());
    assert_eq!(likely.folder(), everything.folder(), "how many are planned is no other fit");
    for wrong in [config(0, 0.0), config(1, 1.5)] {
        let error = made(&wrong, root.path()).err().unwrap().to_string();
        assert!(error.contains("chooser."), "{error}");
    }
}

#[test]
fn a_finished_classifier_is_read_and_a_strange_tool_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let fit = |data: &Split, path: &Path| Classifier::fit(&network(20), data, path, &Watch::silent());
    let first = fit(&split(), folder.path()).unwrap();
    // Episodes that would teach something else are not looked at again.
    let other = Split { train: episodes(0..3), ..split() };
    let again = fit(&other, folder.path()).unwrap();
    let (from, to) = (lump(7), after(1, 7));
    assert_eq!(first.probabilities(&from, &to), again.probabilities(&from, &to));
    let fresh = tempfile::tempdir().unwrap();
    let mut strange = split();
    strange.train[5].tool = "spoon".to_owned();
    assert!(fit(&strange, fresh.path()).err().unwrap().to_string().contains("spoon"));
}

#[test]
fn a_loss_that_is_not_a_number_stops_with_step_and_examples_and_keeps_the_files() {
    let (mut broken, folder) = (split(), tempfile::tempdir().unwrap());
    broken.train.iter_mut().for_each(|episode| episode.states[1].positions[3].x = f64::INFINITY);
    let error = Classifier::fit(&network(20), &broken, folder.path(), &Watch::silent()).err().unwrap().to_string();
    assert!(
        error.contains("before step 1") && error.contains("(examples ") && error.contains("network.rate"),
        "{error}"
    );
    assert!(!folder.path().join("checkpoint.bin").exists());
}

#[test]
fn a_drawn_tool_is_the_seeds_and_the_actions_alone() {
    let root = tempfile::tempdir().unwrap();
    let random = made("kind = 'random'", root.path()).unwrap();
    let drawn = |seed, action| shortlist(random.as_ref(), 0, seed, action);
    let all: Vec<Vec<usize>> = (0..40).map(|seed| drawn(seed, 0)).collect();
    assert!(all.iter().all(|list| list.len() == 1));
    assert!((0..3).all(|tool| all.iter().filter(|list| list[0] == tool).count() > 5), "{all:?}");
    assert_eq!(drawn(3, 1), drawn(3, 1));
    assert!((0..20).any(|action| drawn(3, action) != drawn(3, 0)));
}

#[test]
fn a_fixed_tool_is_planned_alone_and_must_be_there() {
    let root = tempfile::tempdir().unwrap();
    let fixed = made("kind = 'fixed'\ntool = 'pusher'", root.path()).unwrap();
    assert_eq!(shortlist(fixed.as_ref(), 0, 0, 0), [1]);
    let sentence = made("kind = 'fixed'\ntool = 'spoon'", root.path()).err().unwrap().to_string();
    assert!(sentence.contains("spoon") && sentence.contains("press, pusher, none"), "{sentence}");
}
