//! Directions to differentiate along, in everything that a rollout starts from.
use super::problem::{Mixed, STEPS, vector};
use glam::{DQuat, DVec3};
use pliant::model::{Cost, Gradient, WorldModel};
use pliant::state::{Control, Particles, Pose, PoseGrad, Scene, Twist};
use rand_chacha::ChaCha8Rng;

/// A direction in everything that a rollout starts from.
pub(crate) struct Direction {
    pub(crate) positions: Vec<DVec3>,
    pub(crate) velocities: Vec<DVec3>,
    pub(crate) start: Vec<Twist>,
    pub(crate) controls: Vec<Vec<Twist>>,
}

impl Direction {
    /// Random, scaled to move particles, start poses and controls by (up to) the given factors.
    pub(crate) fn random(rng: &mut ChaCha8Rng, particles: f64, start: f64, controls: f64) -> Self {
        let mut rows = |scale: f64| (0..48).map(|_| scale * vector(rng)).collect::<Vec<_>>();
        let (positions, velocities) = (rows(particles), rows(10.0 * particles));
        let mut twists = |scale: f64| {
            let mut twist = || Twist { linear: scale * vector(rng), angular: 20.0 * scale * vector(rng) };
            vec![twist(), twist()]
        };
        let start = twists(start);
        Self { positions, velocities, start, controls: (0..STEPS).map(|_| twists(controls)).collect() }
    }

    pub(crate) fn cost(
        &self,
        model: &dyn WorldModel,
        (scene, controls, cost): &(Scene, Vec<Control>, Mixed),
        h: f64,
    ) -> f64 {
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
