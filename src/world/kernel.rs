//! The smoothing kernel of the fluid: how near particles, and solid ground, count towards its density.
use glam::DVec3;
use std::f64::consts::PI;

/// Desbrun's spiky kernel of compact support h, W(r) = 15/(π h⁶) (h − r)³ (Müller et al. 2003, eq. 21), scaled so that a cubic
/// lattice of spacing h/2 has density 1 within the bulk, and also half a spacing from a plane wall.
#[derive(Clone, Copy)]
pub(super) struct Kernel {
    /// Radius of support h \[m\].
    pub support: f64,
    /// 15/(π h⁶) over the lattice's sum.
    scale: f64,
    /// What a wall counts over what a continuum beyond it would.
    wall: f64,
}

/// Supports in lattice spacings.
pub(super) const SUPPORT: f64 = 2.0;

impl Kernel {
    /// Of a fluid whose particles are `spacing` \[m\] apart at rest.
    pub(super) fn new(spacing: f64) -> Self {
        let support = SUPPORT * spacing;
        let raw = Self { support, scale: 15.0 / (PI * support.powi(6)), wall: 1.0 };
        let layer = |k: i32| -> f64 {
            let around = (-2..=2).flat_map(|i| (-2..=2).map(move |j| DVec3::new(i.into(), j.into(), k.into())));
            around.map(|offset| raw.weight(spacing * offset.length())).sum()
        };
        let whole = (-2..=2).map(layer).sum::<f64>();
        let missing = (layer(1) + layer(2)) / whole;
        Self { scale: raw.scale / whole, wall: missing / raw.ground(spacing / 2.0).0, ..raw }
    }

    /// W at distance `r` \[m\]: the share of the rest density that a particle there makes.
    pub(super) fn weight(&self, r: f64) -> f64 {
        self.scale * (self.support - r).max(0.0).powi(3)
    }

    /// −dW/dr \[1/m\].
    pub(super) fn slope(&self, r: f64) -> f64 {
        3.0 * self.scale * (self.support - r).max(0.0).powi(2)
    }

    /// The density γ that solid ground beyond a plane at distance `s` \[m\] makes, and −dγ/ds \[1/m\].
    ///
    /// The half-space integral of W is γ = q⁵ (3/2 − q) with q = 1 − s/h; behind the plane it is 1 − γ(−s).
    pub(super) fn ground(&self, s: f64) -> (f64, f64) {
        let q = (1.0 - s.abs() / self.support).max(0.0);
        let (part, slope) = (q.powi(5) * (1.5 - q), q.powi(4) * (7.5 - 6.0 * q) / self.support);
        (self.wall * if s < 0.0 { 1.0 - part } else { part }, self.wall * slope)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lattice_has_density_one_in_its_bulk_and_at_a_wall() {
        let spacing = 0.01;
        let kernel = Kernel::new(spacing);
        let density = |layers: std::ops::RangeInclusive<i32>| -> f64 {
            let at = layers.flat_map(|k| (-3..=3).flat_map(move |i| (-3..=3).map(move |j| [i, j, k])));
            at.map(|[i, j, k]| kernel.weight(spacing * DVec3::new(i.into(), j.into(), k.into()).length())).sum()
        };
        assert!((density(-3..=3) - 1.0).abs() < 1e-12);
        assert!((density(0..=3) + kernel.ground(spacing / 2.0).0 - 1.0).abs() < 1e-12);
        assert!((density(-1..=3) + kernel.ground(1.5 * spacing).0 - 1.0).abs() < 0.02);
    }

    #[test]
    fn slopes_are_derivatives_and_the_ground_is_the_integral_of_the_kernel() {
        let kernel = Kernel::new(0.01);
        let step = 1e-8;
        for r in [0.001, 0.006, 0.013, 0.019] {
            let slope = (kernel.weight(r - step) - kernel.weight(r + step)) / (2.0 * step);
            assert!((slope - kernel.slope(r)).abs() < 1e-4 * kernel.slope(r));
            let slope = (kernel.ground(r - step).0 - kernel.ground(r + step).0) / (2.0 * step);
            assert!((slope - kernel.ground(r).1).abs() < 1e-4 * kernel.ground(r).1);
        }
        // Midpoint sums of 2π ρ W over the half-space beyond the plane.
        let (n, h) = (400, kernel.support);
        let cell = h / f64::from(n);
        for s in [0.0, 0.004, 0.011] {
            let middle = |i: i32| (f64::from(i) + 0.5) * cell;
            let ring = |z: f64, rho: f64| 2.0 * PI * rho * kernel.weight(z.hypot(rho)) * cell * cell;
            let sum: f64 =
                (0..n).flat_map(|i| (0..n).map(move |j| (middle(i), middle(j)))).map(|(z, rho)| ring(s + z, rho)).sum();
            let whole: f64 = (0..n).map(|i| 4.0 * PI * middle(i).powi(2) * kernel.weight(middle(i)) * cell).sum();
            let found = kernel.ground(s).0 / kernel.wall;
            assert!((found - sum / whole).abs() < 1e-3, "{found} at {s}, where sums give {}", sum / whole);
        }
    }
}
