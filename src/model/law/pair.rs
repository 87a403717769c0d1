//! Laws between two particles: equal and opposite, so linear momentum is kept to rounding.
use super::{Law, View, ViewGrad};
use glam::DVec3;

/// Place of particle–particle edges in [`crate::graph::EDGE_KINDS`].
pub(in crate::model) const PARTICLE: usize = 0;

/// An acceleration between two particles of equal mass, from their offset `x = xᵢ − xⱼ` and relative velocity `v = vᵢ − vⱼ`.
pub trait Pair: Send + Sync {
    /// Distance at and beyond which it vanishes \[m\].
    fn reach(&self) -> f64;
    /// Longest substep that it bears \[s\].
    fn stable(&self) -> f64 {
        f64::INFINITY
    }
    /// The acceleration of i; j gets the opposite. `square` is |x|², below the square of the reach and above zero.
    fn acceleration(&self, offset: DVec3, square: f64, velocity: DVec3) -> DVec3;
    /// `(∂J/∂x, ∂J/∂v)` from `at` = `∂J/∂acceleration`.
    fn pull(&self, offset: DVec3, square: f64, velocity: DVec3, at: DVec3) -> (DVec3, DVec3);
    /// Names of the constants that it has derivatives by.
    fn constants(&self) -> &[&'static str] {
        &[]
    }
    /// Adds `∂J/∂constants`, in that order, from `at` = `∂J/∂acceleration`.
    fn pull_constants(&self, offset: DVec3, square: f64, velocity: DVec3, at: DVec3, constants: &mut [f64]) {
        let _ = (offset, square, velocity, at);
        assert!(constants.is_empty(), "a law that names constants has no derivatives by them");
    }
}

/// The law that sums a [`Pair`] over the half list of neighbours, each unordered pair once.
pub struct Pairwise<P>(pub P);

/// Calls `visit(i, j, offset, square)` with every pair nearer than `reach`, in the order of the list.
#[inline]
pub(super) fn visit(view: &View<'_>, reach: f64, mut visit: impl FnMut(usize, usize, DVec3, f64)) {
    let positions = &view.particles.positions[..];
    let list = &view.graph.edges[PARTICLE];
    let limit = reach * reach;
    for (i, at) in positions.iter().enumerate() {
        for &j in &list.senders[list.offsets[i] as usize..list.offsets[i + 1] as usize] {
            let offset = *at - positions[j as usize];
            let square = offset.length_squared();
            // Two particles in one place have no direction to push in.
            if square < limit && square > 0.0 {
                visit(i, j as usize, offset, square);
            }
        }
    }
}

impl<P: Pair + 'static> Law for Pairwise<P> {
    fn reach(&self) -> f64 {
        self.0.reach()
    }

    fn stable(&self) -> f64 {
        self.0.stable()
    }

    fn accelerate(&self, view: &View<'_>, out: &mut [DVec3]) {
        let velocities = &view.particles.velocities[..];
        visit(view, self.0.reach(), |i, j, offset, square| {
            let push = self.0.acceleration(offset, square, velocities[i] - velocities[j]);
            out[i] += push;
            out[j] -= push;
        });
    }

    fn accelerate_vjp(&self, view: &View<'_>, out: &[DVec3], grad: &mut ViewGrad<'_>) {
        let velocities = &view.particles.velocities[..];
        let grad = &mut grad.particles;
        visit(view, self.0.reach(), |i, j, offset, square| {
            let (x, v) = self.0.pull(offset, square, velocities[i] - velocities[j], out[i] - out[j]);
            grad.positions[i] += x;
            grad.positions[j] -= x;
            grad.velocities[i] += v;
            grad.velocities[j] -= v;
        });
    }

    fn into_pair(self: Box<Self>) -> Option<Box<dyn Pair>> {
        Some(Box::new(self.0))
    }

    fn constants(&self) -> Vec<&str> {
        self.0.constants().to_vec()
    }

    fn constants_vjp(&self, view: &View<'_>, out: &[DVec3], constants: &mut [f64]) {
        let velocities = &view.particles.velocities[..];
        visit(view, self.0.reach(), |i, j, offset, square| {
            self.0.pull_constants(offset, square, velocities[i] - velocities[j], out[i] - out[j], constants);
        });
    }
}

#[cfg(test)]
mod tests {
    use super::PARTICLE;
    use crate::graph::EDGE_KINDS;

    #[test]
    fn the_half_list_takes_the_place_of_particle_edges() {
        assert_eq!(EDGE_KINDS[PARTICLE].name(), "particle");
    }
}
