//! Quadratic B-splines: how much each of the 27 nodes around a particle is its own (Steffen et al. 2008, eq. 12).
use glam::DVec3;

/// The three nodes nearest to a place along each axis.
pub(super) struct Stencil {
    /// Index of the first node along each axis, a whole number.
    pub(super) base: [f64; 3],
    /// w of each node, axis by axis; a node's weight is the product of its three.
    pub(super) weights: [[f64; 3]; 3],
    /// ∂w/∂x \[1/m\].
    pub(super) slopes: [[f64; 3]; 3],
    /// From the place to each node \[m\].
    pub(super) offsets: [[f64; 3]; 3],
}

impl Stencil {
    /// Around `place` on a grid of this cell \[m\].
    ///
    /// With f ∈ \[½, 3/2) the place in cells from the first node: `w = (½ (3/2 − f)², ¾ − (f − 1)², ½ (f − ½)²)`.
    #[inline]
    pub(super) fn new(place: DVec3, cell: f64) -> Self {
        let inverse = cell.recip();
        let scaled = place * inverse;
        let base = (scaled - 0.5).floor();
        let f = (scaled - base).to_array();
        Self {
            base: base.to_array(),
            weights: f.map(|f| {
                let (a, b, c) = (1.5 - f, f - 1.0, f - 0.5);
                [0.5 * a * a, 0.75 - b * b, 0.5 * c * c]
            }),
            slopes: f.map(|f| [(f - 1.5) * inverse, (2.0 - 2.0 * f) * inverse, (f - 0.5) * inverse]),
            offsets: f.map(|f| [-f * cell, (1.0 - f) * cell, (2.0 - f) * cell]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_reproduce_lines_and_have_the_second_moment_of_a_quarter_cell() {
        let cell = 0.013;
        for x in [-0.02, 0.0, 0.001, 0.0065, 0.1234] {
            let stencil = Stencil::new(DVec3::new(x, -0.7 * x, 0.3 - x), cell);
            for axis in 0..3 {
                let (w, d) = (stencil.weights[axis], stencil.offsets[axis]);
                let moment = |n: i32| (0..3).map(|k| w[k] * d[k].powi(n)).sum::<f64>();
                assert!((moment(0) - 1.0).abs() < 1e-14);
                assert!(moment(1).abs() < 1e-15);
                assert!((moment(2) - cell * cell / 4.0).abs() < 1e-16);
                assert!(w.iter().all(|w| *w >= 0.0));
            }
        }
    }

    #[test]
    fn slopes_are_derivatives() {
        let (cell, h) = (0.01, 1e-7);
        for x in [-0.0172, 0.0031, 0.0099] {
            let at = |x: f64| Stencil::new(DVec3::splat(x), cell);
            for k in 0..3 {
                let difference = (at(x + h).weights[1][k] - at(x - h).weights[1][k]) / (2.0 * h);
                assert!((difference - at(x).slopes[1][k]).abs() < 1e-5 * (1.0 + difference.abs()));
            }
        }
    }
}
