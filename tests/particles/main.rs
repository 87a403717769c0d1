//! Particle models: the integrator, the written laws, and the dough that they make together.
use glam::DVec3;
use pliant::graph::Graph;
use pliant::model::law::{History, Law, LawSpec, View};
use pliant::model::particles::{ParticleModel, ParticlesSpec};
use pliant::model::{ModelSpec, WorldModel};
use pliant::state::{Constants, Control, Part, Particles, Pose, Scene, Solid, ToolShape};
use pliant::tool::Motion;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Deserialize;
use std::sync::Arc;

mod bonds;
mod dough;
mod integrator;
mod motion;
mod rigid;
mod spec;
mod spring;
mod stability;
mod verlet;

#[derive(Deserialize)]
struct Contender {
    dynamics: ModelSpec,
}

fn vector(rng: &mut ChaCha8Rng) -> DVec3 {
    2.0 * DVec3::from_array(rng.random::<[f64; 3]>()) - 1.0
}

fn analytic() -> ParticlesSpec {
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/configs/model/analytic.toml")).unwrap();
    let ModelSpec::Particles(spec) = toml_edit::de::from_str::<Contender>(&text).unwrap().dynamics else {
        panic!("the analytical model is a particle model");
    };
    spec
}

fn analytic_model() -> Box<dyn WorldModel> {
    ModelSpec::Particles(analytic()).build().unwrap()
}

fn law(text: &str) -> Box<dyn Law> {
    toml_edit::de::from_str::<LawSpec>(text).unwrap().build().unwrap()
}

/// What a law says that sees nothing but these particles of one body, and what it remembers of them.
fn seen<T>(particles: &Particles, history: &History, ask: impl FnOnce(&View<'_>) -> T) -> T {
    let (graph, constants, tool) = (Graph::default(), Constants::new(), ToolShape::from(Vec::new()));
    ask(&View {
        particles,
        past: &[],
        body: &vec![0; particles.len()],
        walls: &[],
        graph: &graph,
        constants: &constants,
        tool: &tool,
        poses: &[],
        twists: &[],
        interval: 0.1,
        history,
    })
}

/// A model without drag.
fn model(substeps: usize, laws: Vec<Box<dyn Law>>) -> ParticleModel {
    ParticleModel::new(substeps, 1.0, None, laws).unwrap()
}

/// A block of 6 × 6 × 3 cm as the world shows it to models: 120 points, each farthest from those before, of a lattice of 1 cm
/// that stands 2.5 mm above the table.
fn block() -> Vec<DVec3> {
    let place = |n: usize| DVec3::new((n % 7) as f64 - 3.0, (n / 7 % 7) as f64 - 3.0, (n / 49) as f64 + 0.25);
    let lattice: Vec<DVec3> = (0..196).map(|n| 0.01 * place(n)).collect();
    let mut distances = vec![f64::INFINITY; 196];
    let mut chosen = vec![lattice[0]];
    while chosen.len() < 120 {
        let last = chosen[chosen.len() - 1];
        lattice.iter().zip(&mut distances).for_each(|(x, d)| *d = d.min(x.distance(last)));
        let next = (0..196).rev().max_by(|&a, &b| distances[a].total_cmp(&distances[b])).expect("196 points");
        chosen.push(lattice[next]);
    }
    chosen
}

fn cuboid(x: f64, y: f64, z: f64) -> Part {
    Part { solid: Solid::Cuboid { half: DVec3::new(x, y, z) }, surface: Vec::new() }
}

fn at(z: f64) -> Pose {
    Pose { translation: DVec3::Z * z, ..Pose::default() }
}

/// Particles under one part at these start poses.
fn scene(particles: Particles, parts: Vec<Part>, poses: Vec<Pose>) -> Scene {
    Scene::open(particles, Arc::new(ToolShape::from(parts)), poses, 0.1)
}

/// Particles far from any tool, and `steps` controls that leave it there.
fn alone(particles: Particles, steps: usize) -> (Scene, Vec<Control>) {
    let far = vec![at(10.0)];
    (scene(particles, vec![cuboid(0.01, 0.01, 0.01)], far.clone()), vec![Control { poses: far }; steps])
}
