//! A small lump under two tools, and a cost that looks at every step of it.
use glam::{DQuat, DVec3};
use pliant::model::Cost;
use pliant::state::{Control, Part, Particles, ParticlesGrad, Pose, Scene, Solid, SurfacePoint, ToolShape};
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use std::sync::Arc;

pub(crate) fn vector(rng: &mut ChaCha8Rng) -> DVec3 {
    2.0 * DVec3::from_array(rng.random::<[f64; 3]>()) - 1.0
}

/// `J = Σₜ Σᵢ aᵢ·x + 20 |x|² + bᵢ·v/10`, different at every step.
pub(crate) struct Mixed(pub(crate) Vec<Vec<[DVec3; 2]>>);

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

pub(crate) const STEPS: usize = 5;

/// A small lump between the table, a tilted press that comes down and turns, and a rod that rolls in from the side.
pub(crate) fn problem(rng: &mut ChaCha8Rng) -> (Scene, Vec<Control>, Mixed) {
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
