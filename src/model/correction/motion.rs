//! A law asked for the motion of a whole control step.
use crate::model::law::{Law, View, ViewGrad};
use crate::state::{ParticlesGrad, PoseGrad, Twist};
use glam::DVec3;

/// A law, the learned one, held over one control step without drag: an acceleration a moves a particle by `Δt² a` and makes it faster by
/// `Δt a`, so that an output of one is a displacement of `scale`.
pub(super) struct Motion(pub(super) Box<dyn Law>);

impl Motion {
    /// The change of velocity \[m/s\]; times Δt, of position.
    pub(super) fn of(&self, view: &View<'_>) -> Vec<DVec3> {
        let mut out = vec![DVec3::ZERO; view.particles.len()];
        self.0.accelerate(view, &mut out);
        out.iter_mut().for_each(|a| *a *= view.interval);
        out
    }

    /// `∂J/∂view` from `at` = `∂J/∂(positions, velocities)` that the motion is added to; adds `∂J/∂weights` to `weights`.
    pub(super) fn pull(&self, view: &View<'_>, at: &ParticlesGrad, weights: &mut [f32]) -> ViewGrad<'static> {
        let (count, dt) = (view.particles.len(), view.interval);
        let rows = at.positions.iter().zip(&at.velocities);
        let by_acceleration: Vec<DVec3> = rows.map(|(x, v)| dt * (*v + dt * *x)).collect();
        let mut grad = ViewGrad {
            particles: ParticlesGrad::zero(count),
            past: vec![vec![DVec3::ZERO; count]; view.past.len()],
            poses: vec![PoseGrad::default(); view.poses.len()],
            twists: vec![Twist::default(); view.twists.len()],
            history: Vec::new(),
            weights,
        };
        self.0.accelerate_vjp(view, &by_acceleration, &mut grad);
        ViewGrad { weights: &mut [], ..grad }
    }
}

/// `total += Σ factor rows`.
pub(super) fn add(total: &mut [DVec3], rows: &[DVec3], factor: f64) {
    total.iter_mut().zip(rows).for_each(|(sum, row)| *sum += factor * *row);
}

/// Adds what the tool's part of `from` is to `to`.
pub(super) fn add_tool(to: &mut ViewGrad<'_>, from: &ViewGrad<'_>) {
    to.poses.iter_mut().zip(&from.poses).for_each(|(sum, term)| *sum += *term);
    for (sum, term) in to.twists.iter_mut().zip(&from.twists) {
        sum.linear += term.linear;
        sum.angular += term.angular;
    }
}
