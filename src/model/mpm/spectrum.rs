//! Eigenvalues and eigenvectors of many symmetric matrices at once.
use super::real::{Matrix, Real, Vector};

/// Matrices decomposed side by side.
pub(super) const LANES: usize = 16;

type Lanes<R> = [R; LANES];

/// Symmetric matrices `T = U diag(t) Uᵀ` by cyclic Jacobi rotations (Golub & Van Loan 2013, algorithm 8.5.2), the same ones in
/// every lane and without branches, so that the compiler turns lanes into vector registers. What is off the diagonal falls
/// quadratically from sweep to sweep.
pub(super) struct Spectra<R> {
    /// xx, yy, zz.
    diagonal: [Lanes<R>; 3],
    /// yz, xz, xy: the entry that leaves out each axis.
    off: [Lanes<R>; 3],
    /// U, column by column.
    vectors: [[Lanes<R>; 3]; 3],
}

impl<R: Real> Spectra<R> {
    /// Of identities.
    pub(super) fn new() -> Self {
        let (zero, one) = ([R::ZERO; LANES], [R::ONE; LANES]);
        Self { diagonal: [one; 3], off: [zero; 3], vectors: [[one, zero, zero], [zero, one, zero], [zero, zero, one]] }
    }

    /// Puts a matrix into a lane; only its upper triangle is read.
    #[inline]
    pub(super) fn set(&mut self, lane: usize, matrix: R::Matrix) {
        let [x, y, z] = matrix.entries();
        for (row, value) in self.diagonal.iter_mut().zip([x[0], y[1], z[2]]) {
            row[lane] = value;
        }
        for (row, value) in self.off.iter_mut().zip([z[1], z[0], y[0]]) {
            row[lane] = value;
        }
    }

    /// Decomposes every lane.
    pub(super) fn decompose(&mut self) {
        let (zero, one) = ([R::ZERO; LANES], [R::ONE; LANES]);
        self.vectors = [[one, zero, zero], [zero, one, zero], [zero, zero, one]];
        for _ in 0..R::SWEEPS {
            self.rotate::<0, 1, 2>();
            self.rotate::<0, 2, 1>();
            self.rotate::<1, 2, 0>();
        }
    }

    /// Turns axes P and Q until their off-diagonal entry, number O, vanishes.
    #[inline]
    fn rotate<const P: usize, const Q: usize, const O: usize>(&mut self) {
        let (mut sines, mut cosines) = ([R::ZERO; LANES], [R::ZERO; LANES]);
        for lane in 0..LANES {
            let gap = self.diagonal[Q][lane] - self.diagonal[P][lane];
            let twice = R::of(2.0) * self.off[O][lane];
            // The smallest normal number keeps zero over zero at zero.
            let tangent = twice.copysign(twice * gap) / (gap.abs() + (gap * gap + twice * twice).sqrt() + R::LEAST);
            let cosine = (R::ONE + tangent * tangent).sqrt().recip();
            cosines[lane] = cosine;
            sines[lane] = tangent * cosine;
            let shift = tangent * self.off[O][lane];
            self.diagonal[P][lane] -= shift;
            self.diagonal[Q][lane] += shift;
            self.off[O][lane] = R::ZERO;
        }
        // The entry that leaves out P joins Q and R, and the other way round.
        for lane in 0..LANES {
            let (s, c) = (sines[lane], cosines[lane]);
            let (pr, qr) = (self.off[Q][lane], self.off[P][lane]);
            self.off[Q][lane] = c * pr - s * qr;
            self.off[P][lane] = s * pr + c * qr;
        }
        for row in 0..3 {
            for lane in 0..LANES {
                let (s, c) = (sines[lane], cosines[lane]);
                let (p, q) = (self.vectors[P][row][lane], self.vectors[Q][row][lane]);
                self.vectors[P][row][lane] = c * p - s * q;
                self.vectors[Q][row][lane] = s * p + c * q;
            }
        }
    }

    /// U and t of a lane.
    #[inline]
    pub(super) fn get(&self, lane: usize) -> Spectrum<R> {
        let column = |k: usize| R::Vector::new(std::array::from_fn(|row| self.vectors[k][row][lane]));
        Spectrum {
            vectors: R::Matrix::new(std::array::from_fn(column)),
            values: R::Vector::new(std::array::from_fn(|k| self.diagonal[k][lane])),
        }
    }
}

/// U and t of `T = U diag(t) Uᵀ`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spectrum<R: Real> {
    pub(super) vectors: R::Matrix,
    pub(super) values: R::Vector,
}

impl<R: Real> Spectrum<R> {
    /// `U diag(v) Uᵀ`.
    #[inline]
    pub(super) fn compose(&self, values: R::Vector) -> R::Matrix {
        let ([x, y, z], [a, b, c]) = (self.vectors.columns(), values.to_array());
        R::Matrix::new([x * a, y * b, z * c]) * self.vectors.transpose()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DMat3;
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn recomposes<R: Real>(scales: [f64; 4], rounding: f64) {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let mut spectra = Spectra::<R>::new();
        for trial in 0..400 {
            let matrices: Vec<DMat3> = (0..LANES)
                .map(|_| {
                    let m = DMat3::from_cols_array(&std::array::from_fn(|_| 2.0 * rng.random::<f64>() - 1.0));
                    let more = if trial % 8 < 4 { DMat3::ZERO } else { m + m.transpose() };
                    let matrix = DMat3::IDENTITY + scales[trial % 4] * (m * m.transpose() + more);
                    R::Matrix::of(matrix).wide()
                })
                .collect();
            matrices.iter().enumerate().for_each(|(lane, m)| spectra.set(lane, R::Matrix::of(*m)));
            spectra.decompose();
            for (lane, m) in matrices.iter().enumerate() {
                let found = spectra.get(lane);
                let norm = m.to_cols_array().iter().map(|x| x.abs()).fold(0.0, f64::max);
                assert!(found.compose(found.values).wide().abs_diff_eq(*m, rounding * norm), "{m} is not {found:?}");
                let turn = found.vectors.wide();
                assert!((turn * turn.transpose()).abs_diff_eq(DMat3::IDENTITY, rounding));
            }
        }
    }

    #[test]
    fn matrices_are_recomposed_whatever_their_eigenvalues() {
        recomposes::<f64>([1.0, 1e-3, 1e-9, 0.0], 18.0 * f64::EPSILON);
        recomposes::<f32>([1.0, 1e-2, 1e-5, 0.0], 30.0 * f64::from(f32::EPSILON));
    }
}
