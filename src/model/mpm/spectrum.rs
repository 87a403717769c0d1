//! Eigenvalues and eigenvectors of many symmetric matrices at once.
use glam::{DMat3, DVec3};

/// Matrices decomposed side by side.
pub(super) const LANES: usize = 16;

/// Sweeps of rotations: the off-diagonal share falls quadratically, after four it is rounding.
const SWEEPS: usize = 4;

type Lanes = [f64; LANES];

/// Symmetric matrices `T = U diag(t) Uᵀ` by cyclic Jacobi rotations (Golub & Van Loan 2013, algorithm 8.5.2), the same ones in
/// every lane and without branches, so that the compiler turns lanes into vector registers.
pub(super) struct Spectra {
    /// xx, yy, zz.
    diagonal: [Lanes; 3],
    /// yz, xz, xy: the entry that leaves out each axis.
    off: [Lanes; 3],
    /// U, column by column.
    vectors: [[Lanes; 3]; 3],
}

impl Spectra {
    /// Of identities.
    pub(super) fn new() -> Self {
        let (zero, one) = ([0.0; LANES], [1.0; LANES]);
        Self { diagonal: [one; 3], off: [zero; 3], vectors: [[one, zero, zero], [zero, one, zero], [zero, zero, one]] }
    }

    /// Puts a matrix into a lane; only its upper triangle is read.
    #[inline]
    pub(super) fn set(&mut self, lane: usize, matrix: &DMat3) {
        let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
        for (row, value) in self.diagonal.iter_mut().zip([x.x, y.y, z.z]) {
            row[lane] = value;
        }
        for (row, value) in self.off.iter_mut().zip([z.y, z.x, y.x]) {
            row[lane] = value;
        }
    }

    /// Decomposes every lane.
    pub(super) fn decompose(&mut self) {
        let (zero, one) = ([0.0; LANES], [1.0; LANES]);
        self.vectors = [[one, zero, zero], [zero, one, zero], [zero, zero, one]];
        for _ in 0..SWEEPS {
            self.rotate::<0, 1, 2>();
            self.rotate::<0, 2, 1>();
            self.rotate::<1, 2, 0>();
        }
    }

    /// Turns axes P and Q until their off-diagonal entry, number R, vanishes.
    #[inline]
    fn rotate<const P: usize, const Q: usize, const R: usize>(&mut self) {
        let (mut sines, mut cosines) = ([0.0; LANES], [0.0; LANES]);
        for lane in 0..LANES {
            let gap = self.diagonal[Q][lane] - self.diagonal[P][lane];
            let twice = 2.0 * self.off[R][lane];
            // The smallest normal number keeps zero over zero at zero.
            let tangent =
                twice.copysign(twice * gap) / (gap.abs() + (gap * gap + twice * twice).sqrt() + f64::MIN_POSITIVE);
            let cosine = (1.0 + tangent * tangent).sqrt().recip();
            cosines[lane] = cosine;
            sines[lane] = tangent * cosine;
            let shift = tangent * self.off[R][lane];
            self.diagonal[P][lane] -= shift;
            self.diagonal[Q][lane] += shift;
            self.off[R][lane] = 0.0;
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
    pub(super) fn get(&self, lane: usize) -> Spectrum {
        let column = |k: usize| DVec3::from_array(std::array::from_fn(|row| self.vectors[k][row][lane]));
        Spectrum {
            vectors: DMat3::from_cols(column(0), column(1), column(2)),
            values: DVec3::from_array(std::array::from_fn(|k| self.diagonal[k][lane])),
        }
    }
}

/// U and t of `T = U diag(t) Uᵀ`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spectrum {
    pub(super) vectors: DMat3,
    pub(super) values: DVec3,
}

impl Spectrum {
    /// `U diag(v) Uᵀ`.
    #[inline]
    pub(super) fn compose(&self, values: DVec3) -> DMat3 {
        let DMat3 { x_axis, y_axis, z_axis } = self.vectors;
        DMat3::from_cols(x_axis * values.x, y_axis * values.y, z_axis * values.z) * self.vectors.transpose()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn matrices_are_recomposed_whatever_their_eigenvalues() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let mut spectra = Spectra::new();
        for trial in 0..400 {
            let matrices: Vec<DMat3> = (0..LANES)
                .map(|_| {
                    let m = DMat3::from_cols_array(&std::array::from_fn(|_| 2.0 * rng.random::<f64>() - 1.0));
                    let scale = [1.0, 1e-3, 1e-9, 0.0][trial % 4];
                    DMat3::IDENTITY
                        + scale * (m * m.transpose() + if trial % 8 < 4 { DMat3::ZERO } else { m + m.transpose() })
                })
                .collect();
            matrices.iter().enumerate().for_each(|(lane, m)| spectra.set(lane, m));
            spectra.decompose();
            for (lane, m) in matrices.iter().enumerate() {
                let found = spectra.get(lane);
                let norm = m.to_cols_array().iter().map(|x| x.abs()).fold(0.0, f64::max);
                assert!(found.compose(found.values).abs_diff_eq(*m, 4e-15 * norm), "{m} is not {found:?}");
                assert!((found.vectors * found.vectors.transpose()).abs_diff_eq(DMat3::IDENTITY, 4e-15));
            }
        }
    }
}
