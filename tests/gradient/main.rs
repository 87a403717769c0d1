//! Gradients of whole rollouts against central differences, through tool contact, friction and cohesion.
use agreement::check;
use drift::Drift;
use glam::DVec3;
use memory::Memory;
use pliant::graph::GraphSpec;
use pliant::model::law::Law;
use pliant::model::particles::{ParticleModel, ParticlesSpec};
use pliant::model::{Cost, ModelSpec, WorldModel};
use pliant::state::{Control, Part, Particles, Pose, Scene, Solid, ToolShape, Wall};
use problem::{STEPS, problem};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde::Deserialize;
use std::sync::Arc;

mod agreement;
mod bonds;
mod checkpoints;
mod constants;
mod direction;
mod drift;
mod hybrids;
mod kinds;
mod memory;
mod neural_constants;
mod pairs;
mod problem;
mod projection;
mod spring;
mod verlet;

#[derive(Deserialize)]
struct Contender {
    dynamics: ModelSpec,
}

fn analytic_spec() -> ParticlesSpec {
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/configs/model/analytic.toml")).unwrap();
    match toml_edit::de::from_str::<Contender>(&text).unwrap().dynamics {
        ModelSpec::Particles(spec) => spec,
        _ => panic!("the analytical model is a particle model"),
    }
}

fn analytic_laws() -> Vec<Box<dyn Law>> {
    let spec = analytic_spec();
    spec.laws.into_iter().map(|law| law.build().unwrap()).collect()
}

fn analytic() -> ParticleModel {
    ParticleModel::new(40, 0.01, None, analytic_laws()).unwrap()
}

fn hybrid() -> ParticleModel {
    let graph: GraphSpec =
        toml_edit::de::from_str("kind = \"radius\"\nradius = 0.02\nedges = [\"particle\", \"tool\"]").unwrap();
    let mut laws = analytic_laws();
    laws.push(Box::new(Drift { weights: vec![150.0, 4.0, 0.5] }));
    ParticleModel::new(40, 0.01, Some(graph.build().unwrap()), laws).unwrap()
}

/// The middle layer is a body of its own, and a wall leans on the lump.
fn beside_a_wall(scene: &mut Scene) {
    scene.body = (0..48).map(|i| u32::from(i / 16 == 1)).collect();
    scene.walls = [Wall { normal: DVec3::new(-0.8, 0.0, 0.6), offset: -0.01 }].into();
}

#[test]
fn the_analytical_gradient_agrees_with_central_differences() {
    check(&analytic(), "analytic", |_| ());
}

#[test]
fn the_gradient_through_a_rigid_body_and_beside_a_wall_agrees_with_central_differences() {
    let model = |rigid: Vec<u32>| ModelSpec::Particles(ParticlesSpec { rigid, ..analytic_spec() }).build().unwrap();
    check(&*model(vec![1]), "rigid", beside_a_wall);
    let mut problem = problem(&mut ChaCha8Rng::seed_from_u64(7));
    let end = |scene: &Scene, rigid| model(rigid).rollout(scene, &problem.1)[STEPS].positions.clone();
    let open = end(&problem.0, vec![]);
    beside_a_wall(&mut problem.0);
    let [loose, bound] = [vec![], vec![1]].map(|rigid| end(&problem.0, rigid));
    let apart = |a: &[DVec3], b: &[DVec3]| a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
    assert!(apart(&open, &loose) > 1e-4, "the wall does nothing");
    assert!(apart(&loose, &bound) > 1e-4, "the body is as loose as the rest");
}

#[test]
fn a_hybrid_gradient_agrees_with_central_differences() {
    check(&hybrid(), "hybrid", |_| ());
}

#[test]
fn the_gradient_through_the_past_agrees_with_central_differences() {
    let graph: GraphSpec = toml_edit::de::from_str("kind = \"radius\"\nradius = 0.02\nedges = [\"particle\"]").unwrap();
    let mut laws = analytic_laws();
    laws.push(Box::new(Memory(vec![-9.0, 4.0, 6.0])));
    let model = ParticleModel::new(40, 0.5, Some(graph.build().unwrap()), laws).unwrap();
    check(&model, "memory", |_| ());
    // Two particles apart: every velocity follows from those of the steps before, and of the scene's past.
    let far = vec![Pose { translation: DVec3::Z * 9.0, ..Pose::default() }];
    let tool = Arc::new(ToolShape::from(vec![Part {
        solid: Solid::Cuboid { half: DVec3::splat(0.01) },
        surface: Vec::new(),
    }]));
    let particles = Particles { positions: vec![DVec3::Z, DVec3::Z * 2.0], velocities: vec![DVec3::X, DVec3::Y] };
    let mut scene = Scene::open(particles, tool, far.clone(), 0.1);
    scene.past = vec![vec![DVec3::Y, DVec3::Z]];
    let graph: GraphSpec = toml_edit::de::from_str("kind = \"radius\"\nradius = 0.02\nedges = [\"particle\"]").unwrap();
    let model =
        ParticleModel::new(1, 1.0, Some(graph.build().unwrap()), vec![Box::new(Memory(vec![2.0, 3.0]))]).unwrap();
    let rollout = model.rollout(&scene, &vec![Control { poses: far }; 3]);
    for i in 0..2 {
        let mut v = [[DVec3::ZERO, DVec3::Y, DVec3::X], [DVec3::ZERO, DVec3::Z, DVec3::Y]][i].to_vec();
        for (t, state) in rollout.iter().enumerate().skip(1) {
            let n = v.len();
            v.push(v[n - 1] + 0.1 * (2.0 * v[n - 2] + 3.0 * v[n - 3]));
            assert!(state.velocities[i].distance(v[n]) < 1e-14, "step {t}");
        }
    }
}

#[test]
fn a_hybrid_weight_gradient_agrees_with_central_differences() {
    let problem = problem(&mut ChaCha8Rng::seed_from_u64(11));
    let mut model = hybrid();
    let gradient = model.weight_gradient(&problem.0, &problem.1, &problem.2).unwrap();
    let weights = WorldModel::weights(&model);
    assert_eq!(gradient.weights.len(), 3);
    for i in 0..3 {
        let h = weights[i] / 65536.0;
        let mut nudged = |h: f32| {
            let mut weights = weights.clone();
            weights[i] += h;
            WorldModel::set_weights(&mut model, &weights);
            problem.2.total(&model.rollout(&problem.0, &problem.1))
        };
        let difference = (nudged(h) - nudged(-h)) / (2.0 * f64::from(h));
        let exact = f64::from(gradient.weights[i]);
        assert!(difference.abs() > 1e-9, "weight {i} does nothing");
        assert!((exact - difference).abs() <= 1e-4 * difference.abs(), "weight {i}: {exact} against {difference}");
    }
}

#[test]
fn the_tool_and_every_law_matter_to_the_gradient() {
    let problem = problem(&mut ChaCha8Rng::seed_from_u64(7));
    let force = |laws: Vec<Box<dyn Law>>| {
        let model = ParticleModel::new(40, 0.01, None, laws).unwrap();
        model.gradient(&problem.0, &problem.1, &problem.2).unwrap()
    };
    let whole = force(analytic_laws());
    assert!(whole.controls.iter().all(|u| u.poses.iter().all(|p| p.translation.length() > 1e-3)));
    for left_out in 0..analytic_laws().len() {
        let mut laws = analytic_laws();
        laws.remove(left_out);
        let change = (force(laws).cost - whole.cost).abs();
        assert!(change > 1e-6 * whole.cost.abs(), "law {left_out} does nothing here");
    }
}
