//! Policies on a model whose inverse is known: what carries a workpiece from here to there.
use glam::DVec3;
use pliant::data::Episode;
use pliant::model::{Cost, Dynamics, Gradient, ModelSpec, WorldModel};
use pliant::state::*;
use pliant::tool::{Motion, Tool, Workpiece};
use pliant::train::point_net::PointNetSpec;
use pliant::train::policy::{Policy, PolicySpec};
use pliant::watch::Watch;
use rand::Rng;
use rand::seq::SliceRandom;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

const STEPS: usize = 3;

/// Particles move as the tool does: θ is where their middle went.
struct Carry;

impl Dynamics for Carry {
    type State = (Particles, DVec3);
    fn accepts(&self, scene: &Scene) -> anyhow::Result<()> {
        scene.check()
    }
    fn encode(&self, scene: &Scene) -> (Particles, DVec3) {
        (scene.particles.clone(), scene.poses[0].translation)
    }
    fn step(&self, (particles, from): &(Particles, DVec3), control: &Control) -> (Particles, DVec3) {
        let to = control.poses[0].translation;
        (Particles::at_rest(particles.positions.iter().map(|x| *x + to - *from).collect()), to)
    }
    fn decode(&self, (particles, _): &(Particles, DVec3)) -> Particles {
        particles.clone()
    }
}

/// Counts how often it is asked, and asks the watch to stop when it has been so often.
struct Counted {
    asked: AtomicUsize,
    stop: Option<(Watch, usize)>,
}

impl Counted {
    fn new(stop: Option<(Watch, usize)>) -> Self {
        Self { asked: AtomicUsize::new(0), stop }
    }
}

impl WorldModel for Counted {
    fn accepts(&self, scene: &Scene) -> anyhow::Result<()> {
        WorldModel::accepts(&Carry, scene)
    }
    fn rollout(&self, scene: &Scene, controls: &[Control]) -> Rollout {
        Carry.rollout(scene, controls)
    }
    fn rollouts(&self, scene: &Scene, motions: &[Motion]) -> Vec<Rollout> {
        let asked = self.asked.fetch_add(1, Ordering::SeqCst) + 1;
        if let Some((watch, _)) = self.stop.as_ref().filter(|(_, after)| *after == asked) {
            watch.stop();
        }
        Carry.rollouts(scene, motions)
    }
    fn gradient(&self, _: &Scene, _: &[Control], _: &dyn Cost) -> Option<Gradient> {
        None
    }
    fn weight_gradient(&self, _: &Scene, _: &[Control], _: &dyn Cost) -> Option<Gradient> {
        None
    }
    fn weights(&self) -> Vec<f32> {
        Vec::new()
    }
    fn set_weights(&mut self, _: &[f32]) {}
    fn save_weights(&self, _: &Path) -> anyhow::Result<()> {
        Ok(())
    }
}

/// Goes from where it is by θ = (x, y).
struct Shift(Arc<ToolShape>);

fn shift() -> Shift {
    Shift(Arc::new(ToolShape::from(vec![Part { solid: Solid::Cuboid { half: DVec3::splat(0.01) }, surface: vec![] }])))
}

impl Tool for Shift {
    fn shape(&self) -> &Arc<ToolShape> {
        &self.0
    }
    fn space(&self, _: &Workpiece) -> ActionSpace {
        ActionSpace { names: ["x", "y"].map(String::from).to_vec(), low: vec![-0.03, -0.01], high: vec![0.05, 0.07] }
    }
    fn motion(&self, theta: &[f64], piece: &Workpiece, steps: usize) -> Motion {
        let by = DVec3::new(theta[0], theta[1], 0.0) / steps as f64;
        let pose = |t: usize| Pose { translation: piece.centre + t as f64 * by, ..Pose::default() };
        Motion { start: vec![pose(0)], controls: (1..=steps).map(|t| Control { poses: vec![pose(t)] }).collect() }
    }
}

fn cloud(seed: u64) -> Vec<DVec3> {
    let mut rng = stream(seed, &[1]);
    let mut axis = |half: f64| rng.random_range(-half..half);
    (0..20).map(|_| DVec3::new(axis(0.05), axis(0.03), 0.02 + axis(0.02))).collect()
}

fn starts() -> Vec<Episode> {
    let episode = |seed| Episode {
        tool: "another".to_owned(),
        theta: Vec::new(),
        interval: 0.1,
        start: Vec::new(),
        controls: Vec::new(),
        states: vec![Particles::at_rest(cloud(seed))],
        body: [0; 20].into(),
        walls: [].into(),
        constants: Default::default(),
    };
    (0..8).map(episode).collect()
}

fn spec() -> PolicySpec {
    let network = PointNetSpec { width: 16, steps: 40, batch: 20, log_every: 10, ..PointNetSpec::default() };
    PolicySpec { bins: 5, samples: 60, network }
}

fn fit(spec: &PolicySpec, model: &dyn WorldModel, folder: &Path, watch: &Watch) -> anyhow::Result<Option<Policy>> {
    spec.fit(model, &shift(), &starts(), STEPS, folder, watch)
}

fn fresh(spec: &PolicySpec) -> (Policy, Vec<u8>) {
    let folder = tempfile::tempdir().unwrap();
    let policy = fit(spec, &Carry, folder.path(), &Watch::silent()).unwrap().unwrap();
    (policy, std::fs::read(folder.path().join("weights.safetensors")).unwrap())
}

/// An unseen workpiece, where it should go, and θ.
fn task(seed: u64) -> (Vec<DVec3>, Vec<DVec3>, Vec<f64>) {
    let (current, mut rng) = (cloud(seed), stream(seed, &[2]));
    let theta =
        shift().space(&Workpiece::around(&Particles::at_rest(current.clone()))).at(&[rng.random(), rng.random()]);
    let goal = current.iter().map(|p| *p + DVec3::new(theta[0], theta[1], 0.0)).collect();
    (current, goal, theta)
}

fn proposals(policy: &Policy, current: &[DVec3], goal: &[DVec3], most: usize) -> Vec<Vec<f64>> {
    let space = shift().space(&Workpiece::around(&Particles::at_rest(current.to_vec())));
    let plans = policy.propose(current, goal, &space, most);
    assert!(plans.len() == most && plans.iter().all(|theta| space.contains(theta)), "{plans:?}");
    plans
}

#[test]
fn the_action_that_made_a_goal_is_found_for_workpieces_that_were_never_seen() {
    let network = PointNetSpec { steps: 600, log_every: 50, noise: 0.0, ..spec().network };
    let (policy, _) = fresh(&PolicySpec { samples: 600, network, ..spec() });
    let worst = |plan: &[f64], theta: &[f64]| plan.iter().zip(theta).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let misses: Vec<f64> = (100..150)
        .map(|seed| {
            let (current, goal, theta) = task(seed);
            worst(&proposals(&policy, &current, &goal, 1)[0], &theta)
        })
        .collect();
    let mean = misses.iter().sum::<f64>() / misses.len() as f64;
    // The box is 80 mm wide; a uniform guess misses by 36 mm in the mean.
    assert!(mean < 6e-3, "{mean} m");
    let (current, goal, theta) = task(200);
    let four = proposals(&policy, &current, &goal, 4);
    let distinct = four.iter().enumerate().all(|(i, a)| four[..i].iter().all(|b| a != b));
    assert!(distinct && worst(&four[0], &theta) < 0.02, "{four:?} for {theta:?}");
}

#[test]
fn how_points_are_numbered_changes_no_bit_of_a_proposal() {
    let (policy, _) = fresh(&spec());
    let (current, goal, _) = task(7);
    let shuffled = |cloud: &[DVec3], seed: u64| {
        let mut cloud = cloud.to_vec();
        cloud.shuffle(&mut stream(seed, &[3]));
        cloud
    };
    for seed in 0..5 {
        let (a, b) = (shuffled(&current, seed), shuffled(&goal, 10 + seed));
        assert!(a != current && b != goal);
        assert_eq!(proposals(&policy, &a, &b, 9), proposals(&policy, &current, &goal, 9));
    }
    let (_, elsewhere, _) = task(8);
    assert_ne!(proposals(&policy, &current, &elsewhere, 1), proposals(&policy, &current, &goal, 1));
}

#[test]
fn equal_seeds_give_equal_weights_whatever_the_number_of_threads() {
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| fresh(&spec()).1)
    };
    let one = on(1);
    assert_eq!(one, on(3));
    let network = PointNetSpec { seed: 1, ..spec().network };
    assert_ne!(one, fresh(&PolicySpec { network, ..spec() }).1, "another seed is another fit");
}

#[test]
fn a_fit_that_was_stopped_goes_on_to_the_same_weights_and_a_finished_one_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let watch = Watch::silent();
    let stopping = Counted::new(Some((watch.clone(), 8)));
    let sentence = fit(&spec(), &stopping, folder.path(), &watch).expect_err("it was stopped").to_string();
    assert!(sentence.contains("after step 1 of 40"), "{sentence}");
    let going_on = Counted::new(None);
    fit(&spec(), &going_on, folder.path(), &Watch::silent()).unwrap().unwrap();
    let (policy, weights) = fresh(&spec());
    assert_eq!(std::fs::read(folder.path().join("weights.safetensors")).unwrap(), weights);
    let lines = std::fs::read_to_string(folder.path().join("metrics.jsonl")).unwrap();
    assert_eq!(lines.lines().count(), 4);
    let idle = Counted::new(None);
    let again = fit(&spec(), &idle, folder.path(), &Watch::silent()).unwrap().unwrap();
    assert_eq!(idle.asked.load(Ordering::SeqCst), 0, "what was fitted is read");
    let (current, goal, _) = task(7);
    assert_eq!(proposals(&again, &current, &goal, 4), proposals(&policy, &current, &goal, 4));
}

#[test]
fn the_simulator_and_what_moves_nothing_teach_no_policy() {
    for kind in ["oracle", "still"] {
        let model: ModelSpec = toml_edit::de::from_str(&format!("kind = '{kind}'")).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let own = folder.path().join("policy");
        let policy = fit(&spec(), model.build().unwrap().as_ref(), &own, &Watch::silent()).unwrap();
        assert!(policy.is_none(), "{kind}");
        assert!(!own.exists(), "{kind}: a folder of nothing");
    }
}

#[test]
fn impossible_values_are_sentences_that_name_the_key() {
    let network = |change: fn(&mut PointNetSpec)| {
        let mut spec = spec();
        change(&mut spec.network);
        spec
    };
    let cases = [
        (PolicySpec { bins: 0, ..spec() }, "bins"),
        (PolicySpec { samples: 1, ..spec() }, "samples"),
        (network(|n| n.width = 0), "network.width"),
        (network(|n| n.rate = 2.0), "network.rate"),
        (network(|n| n.extent = 0.0), "network.extent"),
        (network(|n| n.validation = 0.95), "network.validation"),
    ];
    for (spec, key) in cases {
        let folder = tempfile::tempdir().unwrap();
        let error = fit(&spec, &Carry, folder.path(), &Watch::silent()).err().unwrap_or_else(|| panic!("{key}"));
        assert!(format!("{error:#}").contains(key), "{error:#}");
    }
}
