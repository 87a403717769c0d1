//! The law of the material: Hencky's elasticity, and plastic flow where the shear exceeds what it can bear.
use super::real::{Matrix, Real, Vector};
use super::spectrum::Spectrum;

/// Stretches below this count as this: a particle cannot be squeezed to nothing.
const LEAST_STRETCH: f64 = 0.05;

/// Constants per unit of density.
///
/// With the trial left Cauchy–Green tensor `T = U diag(t) Uᵀ` and Hencky's strains `e = ½ ln t`, `ê` their part without volume:
/// where `|ê| > y`, `e ← mean + y ê/|ê|` (von Mises, as in Huang et al. 2021); Kirchhoff's stress is `τ = U diag(2μ e + λ Σe)
/// Uᵀ`, and the elastic tensor kept is `U diag(exp 2e) Uᵀ`. Both are isotropic functions of T, so that neither they nor their
/// derivatives depend on which eigenvectors stand for equal eigenvalues.
#[derive(Clone, Copy)]
pub(super) struct Material<R> {
    /// Shear modulus μ over density \[m²/s²\].
    pub(super) shear: R,
    /// First Lamé constant λ over density \[m²/s²\].
    pub(super) lame: R,
    /// Greatest elastic shear y \[1\].
    pub(super) yields: R,
}

/// Strains before and after flow.
pub(super) struct Strains<R: Real> {
    /// t, none less than the square of [`LEAST_STRETCH`].
    squares: R::Vector,
    /// ½ ln t.
    trial: R::Vector,
    /// ê and its norm.
    shear: R::Vector,
    norm: R,
    /// The share of ê that is kept.
    kept: R,
    /// e.
    elastic: R::Vector,
}

impl<R: Real> Material<R> {
    /// What eigenvalues t of the trial tensor say.
    #[inline]
    pub(super) fn strains(&self, values: R::Vector) -> Strains<R> {
        let least = R::of(LEAST_STRETCH * LEAST_STRETCH);
        let squares = values.to_array().map(|t| if t > least { t } else { least });
        let (squares, trial) = (R::Vector::new(squares), R::Vector::new(squares.map(R::ln)) * R::of(0.5));
        let mean = trial.element_sum() / R::of(3.0);
        let shear = trial - mean;
        let norm = shear.length();
        let kept = if norm > self.yields { self.yields / norm } else { R::ONE };
        let elastic = shear * kept + mean;
        Strains { squares, trial, shear, norm, kept, elastic }
    }

    #[inline]
    fn principal(&self, strains: &Strains<R>) -> R::Vector {
        strains.elastic * (R::of(2.0) * self.shear) + self.lame * strains.trial.element_sum()
    }

    /// The elastic tensor kept and Kirchhoff's stress over density, from `trial` and its spectrum.
    #[inline]
    pub(super) fn flow(&self, trial: R::Matrix, spectrum: &Spectrum<R>) -> (R::Matrix, R::Matrix) {
        let strains = self.strains(spectrum.values);
        let stress = spectrum.compose(self.principal(&strains));
        let as_it_is = strains.kept == R::ONE && strains.squares.to_array() == spectrum.values.to_array();
        let kept = if as_it_is { trial } else { spectrum.compose((strains.elastic * R::of(2.0)).exp()) };
        (kept, stress)
    }

    /// The stress alone.
    #[inline]
    pub(super) fn stress(&self, spectrum: &Spectrum<R>, strains: &Strains<R>) -> R::Matrix {
        spectrum.compose(self.principal(strains))
    }

    /// `∂J/∂trial` from `∂J/∂kept` and `∂J/∂stress`, all symmetric.
    ///
    /// In the frame of U, entry (i, j) of an isotropic function with eigenvalues f moves by `(fᵢ − fⱼ)/(tᵢ − tⱼ)` times that of T
    /// (Ogden 1984, eq. 2.3.13), taken as a limit where eigenvalues meet; the diagonal moves with the eigenvalues.
    #[inline]
    pub(super) fn pull(
        &self,
        spectrum: &Spectrum<R>,
        s: &Strains<R>,
        by_kept: R::Matrix,
        by_stress: R::Matrix,
    ) -> R::Matrix {
        let (two, turn) = (R::of(2.0), spectrum.vectors);
        let back = turn.transpose();
        let (by_kept, by_stress) = ((back * by_kept * turn).entries(), (back * by_stress * turn).entries());
        let flows = s.kept < R::ONE;
        let stretches = if flows { s.elastic.exp() } else { R::Vector::new([R::ONE; 3]) };
        let squares = if flows { stretches * stretches } else { s.squares };
        let diagonal = |m: &[[R; 3]; 3]| R::Vector::new([m[0][0], m[1][1], m[2][2]]);
        let (kept_diagonal, stress_diagonal) = (diagonal(&by_kept), diagonal(&by_stress));
        // By e, then by ½ ln t.
        let by_elastic = stress_diagonal * (two * self.shear) + squares * two * kept_diagonal;
        let mut by_trial = by_elastic;
        if flows {
            let mean = by_elastic.element_sum() / R::of(3.0);
            let direction = s.shear / s.norm;
            by_trial = (by_elastic - mean - direction * direction.dot(by_elastic)) * s.kept + mean;
        }
        by_trial += self.lame * stress_diagonal.element_sum();
        let (values, clamped) = (spectrum.values.to_array(), s.squares.to_array());
        let free = std::array::from_fn(|i| if clamped[i] == values[i] { R::ONE } else { R::ZERO });
        let by_values = (R::Vector::new(free) * by_trial / (s.squares * two)).to_array();
        let (trial, stretches) = (s.trial.to_array(), stretches.to_array());
        let mut by = [[R::ZERO; 3]; 3];
        (0..3).for_each(|i| by[i][i] = by_values[i]);
        for (i, j) in [(0, 1), (0, 2), (1, 2)] {
            let clamp = clamp_slope(&values, &clamped, i, j);
            let slope = log_slope(clamped[i], clamped[j]) * clamp;
            let kept = if flows {
                two * s.kept * slope * stretches[i] * stretches[j] * sinh_over(s.kept * (trial[i] - trial[j]))
            } else {
                clamp
            };
            let entry = kept * by_kept[j][i] + two * self.shear * s.kept * slope * by_stress[j][i];
            (by[j][i], by[i][j]) = (entry, entry);
        }
        turn * R::Matrix::new(by.map(R::Vector::new)) * back
    }
}

/// `(½ ln a − ½ ln b)/(a − b) = artanh(q)/(q (a + b))`, `q = (a − b)/(a + b)`; 1/2a where a = b.
#[inline]
fn log_slope<R: Real>(a: R, b: R) -> R {
    let sum = a + b;
    let q = (a - b) / sum;
    let square = q * q;
    let ratio = if square < R::of(1e-3) {
        let [one, third, fifth, seventh, ninth] = [1.0, 1.0 / 3.0, 0.2, 1.0 / 7.0, 1.0 / 9.0].map(R::of);
        one + square * (third + square * (fifth + square * (seventh + square * (ninth + square / R::of(11.0)))))
    } else {
        q.atanh() / q
    };
    ratio / sum
}

/// `sinh(z)/z`.
#[inline]
fn sinh_over<R: Real>(z: R) -> R {
    let square = z * z;
    if square < R::of(1e-2) {
        let [one, a, b, c, d] = [1.0, 6.0, 20.0, 42.0, 72.0].map(R::of);
        one + square / a * (one + square / b * (one + square / c * (one + square / d)))
    } else {
        z.sinh() / z
    }
}

/// Of what is not less than the least stretch 1, of what both are below it 0.
#[inline]
fn clamp_slope<R: Real>(values: &[R; 3], clamped: &[R; 3], i: usize, j: usize) -> R {
    match (values[i] == clamped[i], values[j] == clamped[j]) {
        (true, true) => R::ONE,
        (false, false) => R::ZERO,
        _ => (clamped[i] - clamped[j]) / (values[i] - values[j]),
    }
}

#[cfg(test)]
mod tests {
    use super::super::spectrum::{LANES, Spectra};
    use super::*;
    use glam::{DMat3, DVec3};
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn decompose<R: Real>(m: R::Matrix) -> Spectrum<R> {
        let mut spectra = Spectra::new();
        spectra.set(LANES - 1, m);
        spectra.decompose();
        spectra.get(LANES - 1)
    }

    fn symmetric(rng: &mut ChaCha8Rng) -> DMat3 {
        let m = DMat3::from_cols_array(&std::array::from_fn(|_| 2.0 * rng.random::<f64>() - 1.0));
        0.5 * (m + m.transpose())
    }

    fn dot(a: &DMat3, b: &DMat3) -> f64 {
        a.to_cols_array().iter().zip(b.to_cols_array()).map(|(a, b)| a * b).sum()
    }

    #[test]
    fn derivatives_agree_with_differences_also_where_eigenvalues_meet_or_flow_begins() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let material = Material::<f64> { shear: 2.0, lame: 3.0, yields: 0.1 };
        let diagonals = [
            [1.0, 1.0, 1.0],
            [1.05, 1.05, 0.98],
            [1.3, 1.3, 0.8],
            [1.3, 1.3 + 1e-9, 0.8],
            [1.2, 0.9, 1.1],
            [2.0, 0.3, 0.7],
            [1.7, 1.7, 1.7],
            [1e-3, 1.1, 0.9],
            [1e-3, 1e-3, 1.2],
        ];
        for diagonal in diagonals {
            let turn = DMat3::from_quat(glam::DQuat::from_scaled_axis(DVec3::new(0.3, -0.8, 0.5)));
            let at = turn * DMat3::from_diagonal(DVec3::from_array(diagonal)) * turn.transpose();
            for _ in 0..20 {
                let (by_kept, by_stress, direction) = (symmetric(&mut rng), symmetric(&mut rng), symmetric(&mut rng));
                let cost = |h: f64| {
                    let trial = at + h * direction;
                    let (kept, stress) = material.flow(trial, &decompose(trial));
                    dot(&kept, &by_kept) + dot(&stress, &by_stress)
                };
                let h = 1e-6;
                let difference = (cost(h) - cost(-h)) / (2.0 * h);
                let spectrum = decompose(at);
                let strains = material.strains(spectrum.values);
                let exact = dot(&material.pull(&spectrum, &strains, by_kept, by_stress), &direction);
                assert!(
                    (exact - difference).abs() < 1e-7 * (1.0 + exact.abs()),
                    "{diagonal:?}: {exact} against {difference}"
                );
            }
        }
    }

    #[test]
    fn flow_bears_so_much_shear_and_keeps_the_volume() {
        let material = Material::<f64> { shear: 2.0, lame: 3.0, yields: 0.02 };
        let stretched = DMat3::from_diagonal(DVec3::new(1.4, 0.8, 1.1));
        let (kept, stress) = material.flow(stretched, &decompose(stretched));
        assert!((kept.determinant() - stretched.determinant()).abs() < 1e-13);
        let mean = (stress.x_axis.x + stress.y_axis.y + stress.z_axis.z) / 3.0;
        let shear = stress - DMat3::from_diagonal(DVec3::splat(mean));
        assert!((dot(&shear, &shear).sqrt() - 2.0 * 2.0 * 0.02).abs() < 1e-13);
        assert!((mean - (2.0 / 3.0 * 2.0 + 3.0) * 0.5 * stretched.determinant().ln()).abs() < 1e-13);
        let little = DMat3::from_diagonal(DVec3::new(1.01, 0.995, 1.0));
        assert_eq!(material.flow(little, &decompose(little)).0, little);
    }
}
