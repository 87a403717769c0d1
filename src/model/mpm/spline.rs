//! Quadratic B-splines: how much each of the 27 nodes around a particle is its own (Steffen et al. 2008, eq. 12).
use super::real::Real;
use glam::DVec3;

/// The three nodes nearest to a place along each axis.
pub(super) struct Stencil<R> {
    /// Index of the first node along each axis, a whole number.
    pub(super) base: [f64; 3],
    /// w of each node, axis by axis; a node's weight is the product of its three.
    pub(super) weights: [[R; 3]; 3],
    /// ∂w/∂x \[1/m\].
    pub(super) slopes: [[R; 3]; 3],
    /// From the place to each node \[m\].
    pub(super) offsets: [[R; 3]; 3],
}

impl<R: Real> Stencil<R> {
    /// Around `place` on a grid of this cell \[m\].
    ///
    /// With f ∈ \[½, 3/2) the place in cells from the first node: `w = (½ (3/2 − f)², ¾ − (f − 1)², ½ (f − ½)²)`.
    ///
    /// Where f64 has the place, f32 has f to its own rounding, however far from the origin that is.
    #[inline]
    pub(super) fn new(place: DVec3, cell: f64) -> Self {
        let inverse = cell.recip();
        let scaled = place * inverse;
        let base = (scaled - 0.5).floor();
        let f = (scaled - base).to_array().map(R::of);
        let [half, one, more, two] = [0.5, 1.0, 1.5, 2.0].map(R::of);
        let (inverse, cell) = (R::of(inverse), R::of(cell));
        Self {
            base: base.to_array(),
            weights: f.map(|f| {
                let (a, b, c) = (more - f, f - one, f - half);
                [half * a * a, R::of(0.75) - b * b, half * c * c]
            }),
            slopes: f.map(|f| [(f - more) * inverse, (two - two * f) * inverse, (f - half) * inverse]),
            offsets: f.map(|f| [-f * cell, (one - f) * cell, (two - f) * cell]),
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
            let stencil = Stencil::<f64>::new(DVec3::new(x, -0.7 * x, 0.3 - x), cell);
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
            let at = |x: f64| Stencil::<f64>::new(DVec3::splat(x), cell);
            for k in 0..3 {
                let difference = (at(x + h).weights[1][k] - at(x - h).weights[1][k]) / (2.0 * h);
                assert!((difference - at(x).slopes[1][k]).abs() < 1e-5 * (1.0 + difference.abs()));
            }
        }
    }
}
