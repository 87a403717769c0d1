//! Stages fit the models that configs name: written constants, a network, and a network beside written laws.
use glam::DVec3;
use pliant::data::Episode;
use pliant::model::{ModelSpec, WorldModel};
use pliant::state::{Control, Part, Particles, Pose, Scene, Solid, SurfacePoint, ToolShape};
use pliant::train::{FitSpec, Split, Tools, evaluate};
use pliant::watch::Watch;
use serde_json::{Value, json};
use std::path::Path;
use std::sync::Arc;

fn written(viscosity: f64, stiffness: f64) -> Value {
    json!({"kind": "particles", "substeps": 8, "keep": 0.02, "laws": [
        {"kind": "viscosity", "rate": viscosity, "reach": 0.012},
        {"kind": "floor", "radius": 0.004, "stiffness": 2e3, "damping": 2.0, "friction": 0.4, "slip": 0.02},
        {"kind": "tool", "radius": 0.004, "stiffness": stiffness, "damping": 2.0, "friction": 0.2, "slip": 0.02},
        {"kind": "gravity", "acceleration": 0.1},
    ]})
}

fn learned() -> Value {
    let edges = json!(["particle", "tool", "floor"]);
    json!({"kind": "learned", "width": 12, "rounds": 1, "sharing": "shared", "edges": edges, "radius": 0.014,
        "scale": 0.004, "seed": 1})
}

/// A model of a network alone, or of the laws of `beside` with a network.
fn with_network(beside: Option<Value>) -> Value {
    let graph = json!({"kind": "radius", "radius": 0.014, "edges": ["particle", "tool", "floor"]});
    let mut model = beside.unwrap_or(json!({"kind": "particles", "substeps": 1, "keep": 0.0, "laws": []}));
    model["graph"] = graph;
    model["laws"].as_array_mut().unwrap().push(learned());
    model
}

fn model(spec: &Value) -> ModelSpec {
    serde_json::from_value(spec.clone()).unwrap()
}

/// A plate comes down on a small block of particles, at a place that depends on `k`.
fn press(world: &dyn WorldModel, k: usize, tools: &Tools) -> Episode {
    let grid = |i: usize, n: usize| 0.008 * (i as f64 - (n as f64 - 1.0) / 2.0);
    let positions =
        (0..18).map(|i| DVec3::new(grid(i % 3, 3), grid(i / 3 % 3, 3), 0.004 + 0.008 * (i / 9) as f64)).collect();
    let side = DVec3::new(0.004 * (k % 3) as f64 - 0.004, 0.003 * (k % 2) as f64, 0.0);
    let pose = |t: usize| Pose { translation: side + DVec3::Z * (0.032 - 0.003 * t as f64), ..Pose::default() };
    let controls: Vec<Control> = (1..=6).map(|t| Control { poses: vec![pose(t)] }).collect();
    let scene = Scene::open(Particles::at_rest(positions), tools["plate"].clone(), vec![pose(0)], 0.1);
    let mut states = world.rollout(&scene, &controls);
    for t in 1..states.len() {
        let before = states[t - 1].positions.clone();
        let now = &mut states[t];
        now.velocities = now.positions.iter().zip(before).map(|(x, b)| (*x - b) / 0.1).collect();
    }
    let (tool, theta) = ("plate".into(), Vec::new());
    let Scene { poses: start, body, walls, constants, .. } = scene;
    Episode { tool, theta, interval: 0.1, start, controls, states, body, walls, constants }
}

fn world() -> Split {
    let half = DVec3::new(0.02, 0.02, 0.01);
    let corner = |i: usize| DVec3::new(0.01 * (i % 3) as f64 - 0.01, 0.01 * (i / 3) as f64 - 0.01, -half.z);
    let surface = (0..9).map(|i| SurfacePoint { position: corner(i), normal: DVec3::NEG_Z }).collect();
    let shape = ToolShape::from(vec![Part { solid: Solid::Cuboid { half }, surface }]);
    let tools = Tools::from([("plate".to_owned(), Arc::new(shape))]);
    let truth = model(&written(40.0, 2e3)).build().unwrap();
    let all: Vec<Episode> = (0..8).map(|k| press(&*truth, k, &tools)).collect();
    Split { train: all[..6].to_vec(), held_out: all[6..].to_vec(), tools }
}

fn fit(stage: Value, spec: &Value, split: &Split, folder: &Path) -> ModelSpec {
    let stage: FitSpec = serde_json::from_value(stage).unwrap();
    stage.build().unwrap().fit(&model(spec), split, folder, &Watch::silent()).unwrap()
}

fn error(spec: ModelSpec, split: &Split) -> f64 {
    evaluate(&*spec.build().unwrap(), &split.held_out, &split.tools).unwrap().one_step
}

fn training(steps: u64) -> Value {
    json!({"kind": "train", "steps": steps, "batch": 4, "horizon": 2, "rate": 5e-3, "warm_up": 10, "last_rate": 0.05,
        "turn": 3.0, "noise": 0.0, "clip": 1.0, "moving": 0.9, "motion": 1e-4, "validation": 0.2, "validation_windows": 4,
        "validation_horizon": 3, "validate_every": 20, "log_every": 20, "keep": "best",
        "weights": "laws.learned.weights", "seed": 0})
}

#[test]
fn written_constants_are_identified_through_a_config() {
    // Whole episodes: velocities in between are differences, as recordings have them, not those the laws had.
    let (split, folder) = (world(), tempfile::tempdir().unwrap());
    let constants = json!({"laws.viscosity.rate": [1.0, 200.0], "laws.tool.stiffness": [100.0, 1e4]});
    let stage = json!({"kind": "identify", "constants": constants, "evaluations": 300, "windows": 4, "horizon": 6,
        "motion": 1e-4, "sigma": 0.2, "seed": 1});
    let start = written(4.0, 500.0);
    let fitted = fit(stage, &start, &split, folder.path());
    let rollout = |spec: ModelSpec| evaluate(&*spec.build().unwrap(), &split.held_out, &split.tools).unwrap().rollout;
    let (before, after) = (rollout(model(&start)), rollout(fitted.clone()));
    assert!(after < 0.02 * before, "{after} m against {before} m before, {fitted:?}");
    let fitted = serde_json::to_value(fitted).unwrap();
    let found = (fitted["laws"][0]["rate"].as_f64().unwrap(), fitted["laws"][2]["stiffness"].as_f64().unwrap());
    assert!((found.0 / 40.0 - 1.0).abs() < 0.02 && (found.1 / 2e3 - 1.0).abs() < 0.02, "{found:?}");
}

#[test]
fn every_search_identifies_the_constants_that_made_the_data() {
    let split = world();
    let start = written(20.0, 1e3);
    let before = evaluate(&*model(&start).build().unwrap(), &split.held_out, &split.tools).unwrap().rollout;
    let searches = [
        ("gradient", 500, 0.02),
        ("cma_then_gradient", 300, 0.02),
        ("least_squares", 100, 1e-3),
        ("bayesian", 100, 0.1),
    ];
    for (search, evaluations, off) in searches {
        let folder = tempfile::tempdir().unwrap();
        let constants = json!({"laws.viscosity.rate": [5.0, 200.0], "laws.tool.stiffness": [300.0, 1e4]});
        let stage = json!({"kind": "identify", "constants": constants, "evaluations": evaluations, "windows": 4, "horizon": 6,
            "motion": 1e-4, "sigma": 0.2, "seed": 1, "search": {"kind": search}});
        let fitted = fit(stage, &start, &split, folder.path());
        let after = evaluate(&*fitted.clone().build().unwrap(), &split.held_out, &split.tools).unwrap().rollout;
        let fitted = serde_json::to_value(fitted).unwrap();
        let found = [
            fitted["laws"][0]["rate"].as_f64().unwrap() / 40.0,
            fitted["laws"][2]["stiffness"].as_f64().unwrap() / 2e3,
        ];
        assert!(found.iter().all(|c| (c - 1.0).abs() < off), "{search}: {found:?} of the truth");
        assert!(after < 0.2 * before, "{search}: {after} m against {before} m before");
    }
}

#[test]
fn a_network_learns_the_world_and_its_config_names_its_weights() {
    let (split, folder) = (world(), tempfile::tempdir().unwrap());
    let fitted = fit(training(400), &with_network(None), &split, folder.path());
    let still = evaluate(&*fitted.clone().build().unwrap(), &split.held_out, &split.tools).unwrap().still_one_step;
    let error = error(fitted.clone(), &split);
    assert!(error < still / 3.0, "one-step error {error} beside {still} of standing still");
    let named = &serde_json::to_value(&fitted).unwrap()["laws"][0]["weights"];
    assert_eq!(named.as_str().unwrap(), folder.path().join("weights.safetensors").to_str().unwrap());
    let report: Value = serde_json::from_slice(&std::fs::read(folder.path().join("train.json")).unwrap()).unwrap();
    assert_eq!(report["held_out"]["one_step"].as_f64().unwrap(), error, "the file holds the weights that were judged");
}

#[test]
fn a_residual_beside_wrong_constants_beats_them_and_starts_where_they_are() {
    let (split, folder) = (world(), tempfile::tempdir().unwrap());
    let (parent, hybrid) = (written(4.0, 500.0), with_network(Some(written(4.0, 500.0))));
    let parent = error(model(&parent), &split);
    assert_eq!(error(model(&hybrid), &split), parent, "an untrained network adds nothing");
    let fitted = error(fit(training(100), &hybrid, &split, folder.path()), &split);
    assert!(fitted < 0.5 * parent, "{fitted} beside {parent} without the network");
}

#[test]
fn every_other_hybrid_is_trained_by_the_same_loop() {
    let (split, parent) = (world(), written(4.0, 500.0));
    let parent_error = error(model(&parent), &split);
    let still = evaluate(&*model(&parent).build().unwrap(), &split.held_out, &split.tools).unwrap().still_one_step;
    let corrected = |kind: &str| {
        let mut spec = parent.clone();
        spec["graph"] = json!({"kind": "radius", "radius": 0.014, "edges": ["particle", "tool", "floor"]});
        spec["corrections"] = json!([learned()]);
        spec["corrections"][0]["kind"] = json!(kind);
        spec
    };
    let mut pair = parent.clone();
    pair["laws"]
        .as_array_mut()
        .unwrap()
        .push(json!({"kind": "learned_pair", "width": 8, "edges": ["particle", "tool", "floor"],
        "radius": 0.012, "skin": 0.004, "strength": 1.0, "speed": 0.05, "seed": 1}));
    // The constants of viscosity alone, ten times too small, and within reach of the network.
    let mut constants = written(4.0, 2e3);
    let viscosity = constants["laws"][0].clone();
    constants["laws"][0] = json!({"kind": "neural_constants", "width": 8, "bound": 3.0, "radius": 0.012, "speed": 0.05, "seed": 1,
        "laws": [viscosity]});
    let wrong = error(model(&written(4.0, 2e3)), &split);
    assert_eq!(error(model(&constants), &split), wrong, "an untrained network changes nothing");
    // The soft plate of this world enters its particles.
    let mut projected = with_network(None);
    projected["corrections"] = json!([{"kind": "projected", "clearance": -0.02, "diameter": 0.004, "bond": 0.01, "stretch": 0.3,
        "limit": 0.03}]);
    let cases = [
        (corrected("output_residual"), "corrections.output_residual.weights", 0.5 * parent_error),
        (corrected("feature"), "corrections.feature.weights", 0.5 * still),
        (pair, "laws.learned_pair.weights", 0.9 * parent_error),
        (constants, "laws.neural_constants.weights", 0.5 * wrong),
        (projected, "laws.learned.weights", 0.5 * still),
    ];
    for (spec, weights, most) in cases {
        let (mut stage, folder) = (training(150), tempfile::tempdir().unwrap());
        stage["weights"] = json!(weights);
        let fitted = fit(stage, &spec, &split, folder.path());
        let error = error(fitted, &split);
        assert!(error < most, "{weights}: {error} beside {most}");
    }
}

#[test]
fn written_laws_are_identified_by_their_own_prediction_where_a_network_hides_it() {
    let (split, folder) = (world(), tempfile::tempdir().unwrap());
    let mut start = written(4.0, 2e3);
    start["graph"] = json!({"kind": "radius", "radius": 0.014, "edges": ["particle", "tool", "floor"]});
    start["corrections"] = json!([learned()]);
    start["corrections"][0]["kind"] = json!("feature");
    let mut stage = json!({"kind": "identify", "constants": {"laws.viscosity.rate": [1.0, 200.0]}, "evaluations": 24, "windows": 4,
        "horizon": 6, "motion": 1e-4, "sigma": 0.2, "seed": 1, "leave_out": ["corrections"]});
    let fitted = serde_json::to_value(fit(stage.clone(), &start, &split, folder.path())).unwrap();
    let moved = fitted["laws"][0]["rate"].as_f64().unwrap();
    assert!(moved > 6.0, "the viscosity went toward the world's 40, not to {moved}");
    assert_eq!(fitted["corrections"][0]["kind"], "feature", "what was left out is still there");
    stage["leave_out"] = json!(["correction"]);
    let stage: FitSpec = serde_json::from_value(stage).unwrap();
    let other = tempfile::tempdir().unwrap();
    let error = stage.build().unwrap().fit(&model(&start), &split, other.path(), &Watch::silent()).unwrap_err();
    assert!(format!("{error:#}").contains("`correction`"), "{error:#}");
}
