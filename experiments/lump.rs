//! A small lump under a press that comes down, slides and turns; directions to change that problem in; and a cost of it.
use glam::{DQuat, DVec3};
use pliant::model::{Cost, Gradient};
use pliant::state::{Control, Part, Particles, ParticlesGrad, Pose, PoseGrad, Scene, Solid, ToolShape, Twist, stream};
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use std::sync::Arc;

/// Distance of neighbours \[m\].
const SPACING: f64 = 0.0095;

/// Three numbers between −1 and 1.
pub(crate) fn vector(rng: &mut ChaCha8Rng) -> DVec3 {
    2.0 * DVec3::from_array(rng.random::<[f64; 3]>()) - 1.0
}

/// A block of `side` × `side` × 3 particles whose lowest stand at `z`, shaken by `shake` \[m\], each at a random velocity of size
/// `speed` \[m/s\].
pub(crate) fn block(side: usize, z: f64, shake: f64, speed: f64) -> Particles {
    let mut rng = stream(5, &[u64::from_le_bytes(*b"lump\0\0\0\0")]);
    let middle = 0.5 * (side as f64 - 1.0);
    let place =
        |n: usize| DVec3::new((n % side) as f64 - middle, (n / side % side) as f64 - middle, (n / side / side) as f64);
    let positions: Vec<_> =
        (0..3 * side * side).map(|n| SPACING * place(n) + z * DVec3::Z + shake * vector(&mut rng)).collect();
    let velocities = positions.iter().map(|_| speed * vector(&mut rng)).collect();
    Particles { positions, velocities }
}

/// Particles under a flat head at this pose.
pub(crate) fn under(particles: Particles, pose: Pose) -> Scene {
    let solid = Solid::Cuboid { half: DVec3::new(0.04, 0.04, 0.006) };
    let shape = ToolShape::from(vec![Part { solid, surface: Vec::new() }]);
    Scene::open(particles, Arc::new(shape), vec![pose], 0.1)
}

/// A head so high that nothing reaches it.
pub(crate) fn away() -> Pose {
    Pose { translation: 10.0 * DVec3::Z, ..Pose::default() }
}

/// The head over `steps` control steps down to the height `low` of its middle, and the scene before.
pub(crate) fn pressed(side: usize, steps: usize, low: f64) -> (Scene, Vec<Control>) {
    let high = 0.035;
    let pose = |t: f64| Pose {
        translation: DVec3::new(0.004 * t, 0.001, high + (low - high) * t),
        rotation: DQuat::from_scaled_axis(DVec3::new(0.1 - 0.05 * t, 0.05, 0.3 * t)),
    };
    let controls = (1..=steps).map(|t| Control { poses: vec![pose(t as f64 / steps as f64)] }).collect();
    (under(block(side, 0.002, 0.001, 0.02), pose(0.0)), controls)
}

/// `J = Σₜ Σᵢ |xᵢ|² + |vᵢ|²/100`.
pub(crate) struct Spread;

impl Cost for Spread {
    fn at(&self, _: usize, _: usize, x: &Particles) -> f64 {
        let rows = x.positions.iter().zip(&x.velocities);
        rows.map(|(x, v)| x.length_squared() + 0.01 * v.length_squared()).sum()
    }

    fn gradient(&self, _: usize, _: usize, x: &Particles) -> ParticlesGrad {
        let scaled = |rows: &[DVec3], by: f64| rows.iter().map(|row| by * *row).collect();
        ParticlesGrad { positions: scaled(&x.positions, 2.0), velocities: scaled(&x.velocities, 0.02) }
    }
}

/// A direction in what a rollout starts from, or in what moves it.
pub(crate) struct Direction {
    positions: Vec<DVec3>,
    velocities: Vec<DVec3>,
    start: Vec<Twist>,
    controls: Vec<Vec<Twist>>,
}

impl Direction {
    /// Random; by `state` in the particles and the tool's start, by `control` in where it goes.
    pub(crate) fn random(
        rng: &mut ChaCha8Rng,
        (scene, controls): &(Scene, Vec<Control>),
        state: f64,
        control: f64,
    ) -> Self {
        let mut rows = |scale: f64| scene.particles.positions.iter().map(|_| scale * vector(rng)).collect();
        let (positions, velocities) = (rows(state), rows(10.0 * state));
        let mut twists = |scale: f64| vec![Twist { linear: scale * vector(rng), angular: 20.0 * scale * vector(rng) }];
        let start = twists(state);
        Self { positions, velocities, start, controls: controls.iter().map(|_| twists(control)).collect() }
    }

    /// The problem a distance `h` along.
    pub(crate) fn moved(&self, (scene, controls): &(Scene, Vec<Control>), h: f64) -> (Scene, Vec<Control>) {
        let add = |rows: &[DVec3], by: &[DVec3]| rows.iter().zip(by).map(|(x, d)| *x + h * *d).collect();
        let turn = |poses: &[Pose], by: &[Twist]| -> Vec<Pose> {
            let turned = |(pose, d): (&Pose, &Twist)| Pose {
                translation: pose.translation + h * d.linear,
                rotation: DQuat::from_scaled_axis(h * d.angular) * pose.rotation,
            };
            poses.iter().zip(by).map(turned).collect()
        };
        let mut scene = scene.clone();
        scene.particles.positions = add(&scene.particles.positions, &self.positions);
        scene.particles.velocities = add(&scene.particles.velocities, &self.velocities);
        scene.poses = turn(&scene.poses, &self.start);
        let controls = controls.iter().zip(&self.controls).map(|(u, by)| Control { poses: turn(&u.poses, by) });
        (scene, controls.collect())
    }

    /// What a gradient says that J changes by along it.
    pub(crate) fn along(&self, gradient: &Gradient) -> f64 {
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
