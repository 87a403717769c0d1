//! Gradients of whole rollouts against central differences, through tool contact, friction and cohesion.
use direction::Direction;
use drift::Drift;
use glam::{DQuat, DVec3};
use memory::Memory;
use pliant::graph::GraphSpec;
use pliant::model::law::Law;
use pliant::model::particles::{ParticleModel, ParticlesSpec};
use pliant::model::{Cost, ModelSpec, WorldModel};
use pliant::state::{Control, Part, Particles, ParticlesGrad, Pose, Scene, Solid, SurfacePoint, ToolShape, Wall};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Deserialize;
use std::sync::Arc;

mod direction;
mod drift;
mod hybrids;
mod memory;
mod pairs;
mod projection;

#[derive(Deserialize)]
struct Contender {
    dynamics: ModelSpec,
}

fn vector(rng: &mut ChaCha8Rng) -> DVec3 {
    2.0 * DVec3::from_array(rng.random::<[f64; 3]>()) - 1.0
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

/// `J = Σₜ Σᵢ aᵢ·x + 20 |x|² + bᵢ·v/10`, different at every step.
pub(crate) struct Mixed(Vec<Vec<[DVec3; 2]>>);

impl Cost for Mixed {
    fn at(&self, t: usize, _: usize, x: &Particles) -> f64 {
        let rows = x.positions.iter().zip(&x.velocities).zip(&self.0[t]);
        rows.map(|((x, v), [a, b])| a.dot(*x) + 20.0 * x.length_squared() + 0.1 * b.dot(*v)).sum()
    }
    fn gradient(&self, t: usize, _: usize, x: &Particles) -> ParticlesGrad {
        ParticlesGrad {
            positions: x.positions.iter().zip(&self.0[t]).map(|(x, [a, _])| *a + 40.0 * *x).collect(),
            velocities: self.0[t].iter().map(|[_, b]| 0.1 * *b).collect(),
        }
    }
}

const STEPS: usize = 5;

/// A small lump between the table, a tilted press that comes down and turns, and a rod that rolls in from the side.
fn problem(rng: &mut ChaCha8Rng) -> (Scene, Vec<Control>, Mixed) {
    let mut positions = Vec::new();
    for n in 0..48 {
        let grid = DVec3::new((n % 4) as f64 - 1.5, (n / 4 % 4) as f64 - 1.5, (n / 16) as f64 + 0.5);
        positions.push(0.0105 * grid + 0.001 * vector(rng));
    }
    let velocities = positions.iter().map(|_| 0.02 * vector(rng)).collect();
    let sample = |normal: DVec3, scale: DVec3| SurfacePoint { position: normal * scale, normal };
    let faces = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::NEG_Z, DVec3::Z];
    let (half, rod) = (DVec3::new(0.016, 0.016, 0.006), DVec3::new(0.006, 0.03, 0.006));
    let tool = ToolShape::from(vec![
        Part { solid: Solid::Cuboid { half }, surface: faces.map(|n| sample(n, half)).to_vec() },
        Part {
            solid: Solid::Cylinder { radius: 0.006, half_length: 0.03 },
            surface: faces.map(|n| sample(n, rod)).to_vec(),
        },
    ]);
    let poses = |t: f64| {
        let turn = DVec3::new(0.15 - 0.1 * t, 0.1, 0.5 * t);
        let roll = DVec3::new(0.1 * t, 2.0 * t, 0.3);
        vec![
            Pose {
                translation: DVec3::new(0.002 * t, 0.001, 0.037 - 0.01 * t),
                rotation: DQuat::from_scaled_axis(turn),
            },
            Pose { translation: DVec3::new(-0.028 + 0.006 * t, 0.0, 0.009), rotation: DQuat::from_scaled_axis(roll) },
        ]
    };
    let controls = (1..=STEPS).map(|t| Control { poses: poses(t as f64 / STEPS as f64) }).collect();
    let scene = Scene::open(Particles { positions, velocities }, Arc::new(tool), poses(0.0), 0.1);
    let cost = Mixed((0..=STEPS).map(|_| (0..48).map(|_| [vector(rng), vector(rng)]).collect()).collect());
    (scene, controls, cost)
}

/// What the scene is besides one body on an open table.
type Change = fn(&mut Scene);

/// The middle layer is a body of its own, and a wall leans on the lump.
fn beside_a_wall(scene: &mut Scene) {
    scene.body = (0..48).map(|i| u32::from(i / 16 == 1)).collect();
    scene.walls = [Wall { normal: DVec3::new(-0.8, 0.0, 0.6), offset: -0.01 }].into();
}

fn check(model: &dyn WorldModel, name: &str, change: Change) {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let mut problem = problem(&mut rng);
    change(&mut problem.0);
    let gradient = model.gradient(&problem.0, &problem.1, &problem.2).expect("a particle model has an adjoint");
    let apart = Direction::random(&mut rng, 0.0, 0.0, 0.0).cost(model, &problem, 0.0);
    assert!((gradient.cost - apart).abs() <= 1e-12 * apart.abs(), "the sweep's cost is the rollout's");
    // Steps small against the lengths over which a contact's second derivative changes, large against rounding; of several,
    // because a contact that just closes within one of them bends the cost there.
    let steps = [1e-8, 2e-9, 5e-10];
    let kinds =
        [("particles", [1.0, 0.0, 0.0]), ("start", [0.0, 1.0, 0.0]), ("controls", [0.0, 0.0, 1.0]), ("all", [1.0; 3])];
    for (what, [particles, start, controls]) in kinds {
        let trials: Vec<(f64, [f64; 3])> = (0..8)
            .map(|_| {
                let direction = Direction::random(&mut rng, particles, start, controls);
                let cost = |h: f64| direction.cost(model, &problem, h);
                (direction.along(&gradient), steps.map(|h| (cost(h) - cost(-h)) / (2.0 * h)))
            })
            .collect();
        let typical = (trials.iter().map(|(_, d)| d[1] * d[1]).sum::<f64>() / trials.len() as f64).sqrt();
        assert!(typical > 0.1, "{name}, {what}: derivatives of about {typical} show nothing");
        for (exact, differences) in trials {
            let errors = differences.map(|d| (exact - d).abs() / d.abs().max(typical));
            assert!(errors.iter().all(|e| *e <= 1e-4), "{name}, {what}: {exact} against {differences:?}");
            assert!(errors.iter().any(|e| *e <= 1e-6), "{name}, {what}: {exact} against {differences:?}");
        }
    }
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
