//! Gradients of whole rollouts against central differences, through tool contact, friction and cohesion.
use glam::{DQuat, DVec3};
use pliant::graph::{Graph, GraphSpec};
use pliant::model::law::{Law, Rate, View, ViewGrad};
use pliant::model::particles::ParticleModel;
use pliant::model::{Cost, Gradient, ModelSpec, WorldModel};
use pliant::state::{
    Control, Part, Particles, ParticlesGrad, Pose, PoseGrad, Scene, Solid, SurfacePoint, ToolShape, Twist,
};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Deserialize;
use std::sync::Arc;

#[derive(Deserialize)]
struct Contender {
    dynamics: ModelSpec,
}

fn vector(rng: &mut ChaCha8Rng) -> DVec3 {
    2.0 * DVec3::from_array(rng.random::<[f64; 3]>()) - 1.0
}

fn analytic_laws() -> Vec<Box<dyn Law>> {
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/configs/model/analytic.toml")).unwrap();
    let ModelSpec::Particles(spec) = toml_edit::de::from_str::<Contender>(&text).unwrap().dynamics else {
        panic!("the analytical model is a particle model");
    };
    spec.laws.into_iter().map(|law| law.build().unwrap()).collect()
}

fn analytic() -> ParticleModel {
    ParticleModel::new(40, 0.01, None, analytic_laws()).unwrap()
}

fn hybrid() -> ParticleModel {
    let graph: GraphSpec =
        toml_edit::de::from_str("kind = \"radius\"\nradius = 0.015\nedges = [\"particle\", \"tool\"]").unwrap();
    let mut laws = analytic_laws();
    laws.push(Box::new(Drift { weights: vec![150.0, 4.0, 0.5] }));
    ParticleModel::new(40, 0.01, Some(graph.build().unwrap()), laws).unwrap()
}

/// A law asked once a step, with weights: neighbours pull (w₀), tool samples push (w₁) and drag along (w₂), all fading smoothly.
struct Drift {
    weights: Vec<f32>,
}

const FADE: f64 = 0.015;

impl Drift {
    /// Calls back with each edge: (receiver, sender or sample's part, offset, fade, its slope, sample's velocity).
    fn edges(
        graph: &Graph,
        view: &View<'_>,
        mut visit: impl FnMut(usize, Result<usize, usize>, DVec3, f64, f64, DVec3),
    ) {
        for kind in 0..2 {
            for (i, j) in graph.edges[kind].pairs() {
                let sender = if kind == 0 { Ok(j) } else { Err(graph.nodes.parts[j].unwrap() as usize) };
                let offset = view.particles.positions[i] - graph.nodes.positions[j];
                let rest = 1.0 - offset.length_squared() / (FADE * FADE);
                let velocity = sender.err().map_or(DVec3::ZERO, |k| {
                    let arm = graph.nodes.positions[j] - view.poses[k].translation;
                    view.twists[k].linear + view.twists[k].angular.cross(arm)
                });
                visit(i, sender, offset, rest.max(0.0).powi(2), -4.0 * rest.max(0.0) / (FADE * FADE), velocity);
            }
        }
    }
}

impl Law for Drift {
    fn rate(&self) -> Rate {
        Rate::Step
    }
    fn weights(&self) -> Vec<f32> {
        self.weights.clone()
    }
    fn set_weights(&mut self, weights: &[f32]) {
        self.weights = weights.to_vec();
    }
    fn accelerate(&self, view: &View<'_>, out: &mut [DVec3]) {
        let w: Vec<f64> = self.weights.iter().map(|w| f64::from(*w)).collect();
        Self::edges(view.graph, view, |i, sender, offset, fade, _, velocity| {
            out[i] += match sender {
                Ok(_) => -w[0] * fade * offset,
                Err(_) => fade * (w[1] * offset / FADE + w[2] * (velocity - view.particles.velocities[i])),
            };
        });
    }
    fn accelerate_vjp(&self, view: &View<'_>, out: &[DVec3], grad: &mut ViewGrad<'_>) {
        let w: Vec<f64> = self.weights.iter().map(|w| f64::from(*w)).collect();
        Self::edges(view.graph, view, |i, sender, offset, fade, slope, velocity| {
            let at = out[i];
            let relative = velocity - view.particles.velocities[i];
            let (force, straight) = match sender {
                Ok(_) => (-w[0] * offset, -w[0]),
                Err(_) => (w[1] * offset / FADE + w[2] * relative, w[1] / FADE),
            };
            let by_offset = at.dot(force) * slope * offset + fade * straight * at;
            grad.particles.positions[i] += by_offset;
            let asked = !grad.weights.is_empty();
            match sender {
                Ok(j) => {
                    grad.particles.positions[j] -= by_offset;
                    if asked {
                        grad.weights[0] -= (fade * at.dot(offset)) as f32;
                    }
                }
                Err(k) => {
                    let by_velocity = fade * w[2] * at;
                    let arm = view.particles.positions[i] - offset - view.poses[k].translation;
                    // The sample sits at x − offset and turns with its part; its velocity turns with the arm.
                    let by_sample = by_velocity.cross(view.twists[k].angular) - by_offset;
                    grad.particles.velocities[i] -= by_velocity;
                    grad.poses[k].translation -= by_offset;
                    grad.poses[k].rotation += arm.cross(by_sample);
                    grad.twists[k].linear += by_velocity;
                    grad.twists[k].angular += arm.cross(by_velocity);
                    if asked {
                        grad.weights[1] += (fade * at.dot(offset) / FADE) as f32;
                        grad.weights[2] += (fade * at.dot(relative)) as f32;
                    }
                }
            }
        });
    }
}

/// `J = Σₜ Σᵢ aᵢ·x + 20 |x|² + bᵢ·v/10`, different at every step.
struct Mixed(Vec<Vec<[DVec3; 2]>>);

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
        positions.push(0.008 * grid + 0.0008 * vector(rng));
    }
    let velocities = positions.iter().map(|_| 0.02 * vector(rng)).collect();
    let sample = |normal: DVec3, scale: DVec3| SurfacePoint { position: normal * scale, normal };
    let faces = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::NEG_Z, DVec3::Z];
    let (half, rod) = (DVec3::new(0.012, 0.012, 0.006), DVec3::new(0.006, 0.03, 0.006));
    let tool = ToolShape {
        parts: vec![
            Part { solid: Solid::Cuboid { half }, surface: faces.map(|n| sample(n, half)).to_vec() },
            Part {
                solid: Solid::Cylinder { radius: 0.006, half_length: 0.03 },
                surface: faces.map(|n| sample(n, rod)).to_vec(),
            },
        ],
    };
    let poses = |t: f64| {
        let turn = DVec3::new(0.15 - 0.1 * t, 0.1, 0.5 * t);
        let roll = DVec3::new(0.1 * t, 2.0 * t, 0.3);
        vec![
            Pose {
                translation: DVec3::new(0.002 * t, 0.001, 0.034 - 0.01 * t),
                rotation: DQuat::from_scaled_axis(turn),
            },
            Pose { translation: DVec3::new(-0.022 + 0.006 * t, 0.0, 0.009), rotation: DQuat::from_scaled_axis(roll) },
        ]
    };
    let controls = (1..=STEPS).map(|t| Control { poses: poses(t as f64 / STEPS as f64) }).collect();
    let scene = Scene {
        particles: Particles { positions, velocities },
        tool: Arc::new(tool),
        poses: poses(0.0),
        interval: 0.1,
        snapshot: None,
    };
    let cost = Mixed((0..=STEPS).map(|_| (0..48).map(|_| [vector(rng), vector(rng)]).collect()).collect());
    (scene, controls, cost)
}

/// A direction in everything that a rollout starts from.
struct Direction {
    positions: Vec<DVec3>,
    velocities: Vec<DVec3>,
    start: Vec<Twist>,
    controls: Vec<Vec<Twist>>,
}

impl Direction {
    /// Random, scaled to move particles, start poses and controls by (up to) the given factors.
    fn random(rng: &mut ChaCha8Rng, particles: f64, start: f64, controls: f64) -> Self {
        let mut rows = |scale: f64| (0..48).map(|_| scale * vector(rng)).collect::<Vec<_>>();
        let (positions, velocities) = (rows(particles), rows(10.0 * particles));
        let mut twists = |scale: f64| {
            let mut twist = || Twist { linear: scale * vector(rng), angular: 20.0 * scale * vector(rng) };
            vec![twist(), twist()]
        };
        let start = twists(start);
        Self { positions, velocities, start, controls: (0..STEPS).map(|_| twists(controls)).collect() }
    }

    fn cost(&self, model: &dyn WorldModel, (scene, controls, cost): &(Scene, Vec<Control>, Mixed), h: f64) -> f64 {
        let add = |rows: &[DVec3], by: &[DVec3]| rows.iter().zip(by).map(|(x, d)| *x + h * *d).collect();
        let turn = |poses: &[Pose], by: &[Twist]| -> Vec<Pose> {
            let moved = poses.iter().zip(by).map(|(pose, d)| Pose {
                translation: pose.translation + h * d.linear,
                rotation: DQuat::from_scaled_axis(h * d.angular) * pose.rotation,
            });
            moved.collect()
        };
        let mut scene = scene.clone();
        scene.particles = Particles {
            positions: add(&scene.particles.positions, &self.positions),
            velocities: add(&scene.particles.velocities, &self.velocities),
        };
        scene.poses = turn(&scene.poses, &self.start);
        let controls: Vec<_> =
            controls.iter().zip(&self.controls).map(|(u, by)| Control { poses: turn(&u.poses, by) }).collect();
        cost.total(&model.rollout(&scene, &controls))
    }

    fn along(&self, gradient: &Gradient) -> f64 {
        let dot = |a: &[DVec3], b: &[DVec3]| a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum::<f64>();
        let work = |a: &[PoseGrad], b: &[Twist]| -> f64 {
            a.iter().zip(b).map(|(a, b)| a.translation.dot(b.linear) + a.rotation.dot(b.angular)).sum()
        };
        dot(&gradient.scene.particles.positions, &self.positions)
            + dot(&gradient.scene.particles.velocities, &self.velocities)
            + work(&gradient.scene.poses, &self.start)
            + gradient.controls.iter().zip(&self.controls).map(|(g, d)| work(&g.poses, d)).sum::<f64>()
    }
}

fn check(model: &dyn WorldModel, name: &str) {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let problem = problem(&mut rng);
    let gradient = model.gradient(&problem.0, &problem.1, &problem.2).expect("a particle model has an adjoint");
    let apart = Direction::random(&mut rng, 0.0, 0.0, 0.0).cost(model, &problem, 0.0);
    assert!((gradient.cost - apart).abs() <= 1e-12 * apart.abs(), "the sweep's cost is the rollout's");
    for (what, scale) in
        [("particles", [1.0, 0.0, 0.0]), ("start", [0.0, 1.0, 0.0]), ("controls", [0.0, 0.0, 1.0]), ("all", [1.0; 3])]
    {
        for trial in 0..8 {
            let direction = Direction::random(&mut rng, scale[0], scale[1], scale[2]);
            let h = 1e-7;
            let difference = (direction.cost(model, &problem, h) - direction.cost(model, &problem, -h)) / (2.0 * h);
            let exact = direction.along(&gradient);
            eprintln!(
                "{name} {what} {trial}: {exact:.9} against {difference:.9}, {:.1e}",
                ((exact - difference) / difference).abs()
            );
            assert!(difference.abs() > 1e-3, "{name}, {what} {trial}: the difference {difference} shows nothing");
            assert!(
                (exact - difference).abs() <= 1e-6 * difference.abs().max(1.0),
                "{name}, {what} {trial}: {exact} against {difference}"
            );
        }
    }
}

#[test]
fn the_analytical_gradient_agrees_with_central_differences() {
    check(&analytic(), "analytic");
}

#[test]
fn a_hybrid_gradient_agrees_with_central_differences() {
    check(&hybrid(), "hybrid");
}

#[test]
fn a_hybrid_weight_gradient_agrees_with_central_differences() {
    let problem = problem(&mut ChaCha8Rng::seed_from_u64(11));
    let mut model = hybrid();
    let gradient = model.weight_gradient(&problem.0, &problem.1, &problem.2).unwrap();
    let weights = WorldModel::weights(&model);
    assert_eq!(gradient.weights.len(), 3);
    for i in 0..3 {
        let h = weights[i] / 1024.0;
        let mut nudged = |h: f32| {
            let mut weights = weights.clone();
            weights[i] += h;
            WorldModel::set_weights(&mut model, &weights);
            problem.2.total(&model.rollout(&problem.0, &problem.1))
        };
        let difference = (nudged(h) - nudged(-h)) / (2.0 * f64::from(h));
        let exact = f64::from(gradient.weights[i]);
        eprintln!("weight {i}: {exact} against {difference}");
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
