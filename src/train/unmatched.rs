//! The error where rows of prediction and truth are not the same particles: a distance between shapes.
use crate::metric::ShapeLoss;
use crate::model::Cost;
use crate::state::{Particles, ParticlesGrad};

/// Mean shape distance in units of a typical step, `J = 1/K Σ_{t=1..K} ℓ(x(t), x*(t)) / scale`.
pub struct Unmatched<'a> {
    /// x*, K states; their rows are in any order.
    pub targets: &'a [Particles],
    /// What a particle moves in a step, typically \[m\].
    pub scale: f64,
    /// ℓ \[m\].
    pub loss: &'a dyn ShapeLoss,
}

impl Unmatched<'_> {
    fn target(&self, t: usize) -> Option<&Particles> {
        t.checked_sub(1).and_then(|t| self.targets.get(t))
    }

    /// `1 / (K scale)`.
    fn weight(&self) -> f64 {
        1.0 / (self.targets.len() as f64 * self.scale)
    }
}

impl Cost for Unmatched<'_> {
    fn at(&self, t: usize, _: usize, particles: &Particles) -> f64 {
        let value = self.target(t).map(|target| self.loss.value(&particles.positions, &target.positions));
        value.map_or(0.0, |value| self.weight() * value)
    }

    fn gradient(&self, t: usize, _: usize, particles: &Particles) -> ParticlesGrad {
        let mut gradient = ParticlesGrad::zero(particles.len());
        if let Some(target) = self.target(t) {
            gradient.positions = self.loss.gradient(&particles.positions, &target.positions);
            gradient.positions.iter_mut().for_each(|g| *g *= self.weight());
        }
        gradient
    }
}
