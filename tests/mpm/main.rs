//! The material point method: what it must conserve, how its dough behaves, and its gradients.
use glam::DVec3;
use pliant::model::mpm::{MpmModel, MpmSpec, Precision, SurfaceSpec};
use pliant::model::{Checkpoints, Dynamics, ModelSpec, WorldModel};
use pliant::state::{Control, Part, Particles, Pose, Scene, Solid, ToolShape};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde::Deserialize;
use std::sync::Arc;

#[path = "../gradient/agreement.rs"]
mod agreement;
#[path = "../gradient/direction.rs"]
mod direction;
mod dough;
mod gradient;
mod motion;
mod precision;
#[path = "../gradient/problem.rs"]
mod problem;
mod spec;

#[derive(Deserialize)]
struct Contender {
    dynamics: ModelSpec,
}

/// The model as configured.
fn shipped() -> MpmSpec {
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/configs/model/mpm.toml")).unwrap();
    match toml_edit::de::from_str::<Contender>(&text).unwrap().dynamics {
        ModelSpec::Mpm(spec) => spec,
        _ => panic!("the shipped file holds another model"),
    }
}

/// An elastic material that no force pulls at.
fn elastic() -> MpmSpec {
    MpmSpec {
        cell: 0.01,
        courant: 0.3,
        density: 1200.0,
        young_modulus: 5e3,
        poisson_ratio: 0.3,
        yield_stress: 1e9,
        viscosity: 0.0,
        gravity: 0.0,
        table: SurfaceSpec::Coulomb { friction: 0.3 },
        tool: SurfaceSpec::Coulomb { friction: 0.2 },
        softness: 0.001,
        precision: Precision::Double,
        checkpoints: Checkpoints::default(),
    }
}

fn model(spec: MpmSpec) -> MpmModel {
    MpmModel::new(spec).unwrap()
}

/// A lattice of 5 mm whose lowest particles are `z` above the table: 8 × 8 × 6 of them, 4 × 4 × 3 cm.
fn block(z: f64) -> Vec<DVec3> {
    let place = |n: usize| DVec3::new((n % 8) as f64 - 3.5, (n / 8 % 8) as f64 - 3.5, (n / 64) as f64);
    (0..384).map(|n| 0.005 * place(n) + z * DVec3::Z).collect()
}

fn at(z: f64) -> Pose {
    Pose { translation: DVec3::Z * z, ..Pose::default() }
}

/// Particles under a flat head at height `z`.
fn under(particles: Particles, z: f64) -> Scene {
    let part = Part { solid: Solid::Cuboid { half: DVec3::new(0.05, 0.05, 0.01) }, surface: Vec::new() };
    Scene::open(particles, Arc::new(ToolShape::from(vec![part])), vec![at(z)], 0.1)
}

/// Particles far from any tool, and `steps` controls that leave it there.
fn alone(particles: Particles, steps: usize) -> (Scene, Vec<Control>) {
    (under(particles, 10.0), vec![Control { poses: vec![at(10.0)] }; steps])
}

/// The lattice in the air, each particle with a velocity of its own.
fn stirred() -> Particles {
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let positions = block(1.0);
    let turn = |x: &DVec3| DVec3::new(0.5, -0.3, 2.0).cross(*x - DVec3::Z);
    let velocities = positions.iter().map(|x| turn(x) + 0.05 * problem::vector(&mut rng)).collect();
    Particles { positions, velocities }
}
