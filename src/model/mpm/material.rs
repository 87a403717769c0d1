//! The law of the material: Hencky's elasticity, and plastic flow where the shear exceeds what it can bear.
use super::spectrum::Spectrum;
use glam::{DMat3, DVec3};

/// Stretches below this count as this: a particle cannot be squeezed to nothing.
const LEAST_STRETCH: f64 = 0.05;

/// Constants per unit of density.
///
/// With the trial left Cauchy–Green tensor `T = U diag(t) Uᵀ` and Hencky's strains `e = ½ ln t`, `ê` their part without volume:
/// where `|ê| > y`, `e ← mean + y ê/|ê|` (von Mises, as in Huang et al. 2021); Kirchhoff's stress is `τ = U diag(2μ e + λ Σe)
/// Uᵀ`, and the elastic tensor kept is `U diag(exp 2e) Uᵀ`. Both are isotropic functions of T, so that neither they nor their
/// derivatives depend on which eigenvectors stand for equal eigenvalues.
pub(super) struct Material {
    /// Shear modulus μ over density \[m²/s²\].
    pub(super) shear: f64,
    /// First Lamé constant λ over density \[m²/s²\].
    pub(super) lame: f64,
    /// Greatest elastic shear y \[1\].
    pub(super) yields: f64,
}

/// Strains before and after flow.
pub(super) struct Strains {
    /// t, none less than the square of [`LEAST_STRETCH`].
    squares: DVec3,
    /// ½ ln t.
    trial: DVec3,
    /// ê and its norm.
    shear: DVec3,
    norm: f64,
    /// The share of ê that is kept.
    kept: f64,
    /// e.
    elastic: DVec3,
}

impl Material {
    /// What eigenvalues t of the trial tensor say.
    #[inline]
    pub(super) fn strains(&self, values: DVec3) -> Strains {
        let squares = values.max(DVec3::splat(LEAST_STRETCH * LEAST_STRETCH));
        let trial = 0.5 * squares.map(f64::ln);
        let mean = trial.element_sum() / 3.0;
        let shear = trial - mean;
        let norm = shear.length();
        let kept = if norm > self.yields { self.yields / norm } else { 1.0 };
        let elastic = mean + kept * shear;
        Strains { squares, trial, shear, norm, kept, elastic }
    }

    #[inline]
    fn principal(&self, strains: &Strains) -> DVec3 {
        2.0 * self.shear * strains.elastic + self.lame * strains.trial.element_sum()
    }

    /// The elastic tensor kept and Kirchhoff's stress over density, from `trial` and its spectrum.
    #[inline]
    pub(super) fn flow(&self, trial: &DMat3, spectrum: &Spectrum) -> (DMat3, DMat3) {
        let strains = self.strains(spectrum.values);
        let stress = spectrum.compose(self.principal(&strains));
        let as_it_is = strains.kept == 1.0 && strains.squares == spectrum.values;
        let kept = if as_it_is { *trial } else { spectrum.compose((2.0 * strains.elastic).exp()) };
        (kept, stress)
    }

    /// The stress alone.
    #[inline]
    pub(super) fn stress(&self, spectrum: &Spectrum, strains: &Strains) -> DMat3 {
        spectrum.compose(self.principal(strains))
    }

    /// `∂J/∂trial` from `∂J/∂kept` and `∂J/∂stress`, all symmetric.
    ///
    /// In the frame of U, entry (i, j) of an isotropic function with eigenvalues f moves by `(fᵢ − fⱼ)/(tᵢ − tⱼ)` times that of T
    /// (Ogden 1984, eq. 2.3.13), taken as a limit where eigenvalues meet; the diagonal moves with the eigenvalues.
    #[inline]
    pub(super) fn pull(&self, spectrum: &Spectrum, s: &Strains, by_kept: &DMat3, by_stress: &DMat3) -> DMat3 {
        let (turn, values) = (spectrum.vectors, spectrum.values);
        let back = turn.transpose();
        let (by_kept, by_stress) = (back * *by_kept * turn, back * *by_stress * turn);
        let flows = s.kept < 1.0;
        let stretches = if flows { s.elastic.exp() } else { DVec3::ONE };
        let squares = if flows { stretches * stretches } else { s.squares };
        let diagonal = |m: &DMat3| DVec3::new(m.x_axis.x, m.y_axis.y, m.z_axis.z);
        let (kept_diagonal, stress_diagonal) = (diagonal(&by_kept), diagonal(&by_stress));
        // By e, then by ½ ln t.
        let by_elastic = 2.0 * self.shear * stress_diagonal + 2.0 * squares * kept_diagonal;
        let mut by_trial = by_elastic;
        if flows {
            let mean = by_elastic.element_sum() / 3.0;
            let direction = s.shear / s.norm;
            by_trial = mean + s.kept * (by_elastic - mean - direction * direction.dot(by_elastic));
        }
        by_trial += self.lame * stress_diagonal.element_sum();
        let free = DVec3::select(s.squares.cmpeq(values), DVec3::ONE, DVec3::ZERO);
        let by_values = free * by_trial / (2.0 * s.squares);
        let mut by = DMat3::from_diagonal(by_values);
        for (i, j) in [(0, 1), (0, 2), (1, 2)] {
            let slope = log_slope(s.squares[i], s.squares[j]) * clamp_slope(values, s.squares, i, j);
            let spread = s.kept * (s.trial[i] - s.trial[j]);
            let kept = if flows {
                2.0 * s.kept * slope * stretches[i] * stretches[j] * sinh_over(spread)
            } else {
                clamp_slope(values, s.squares, i, j)
            };
            let entry = kept * by_kept.col(j)[i] + 2.0 * self.shear * s.kept * slope * by_stress.col(j)[i];
            by.col_mut(j)[i] = entry;
            by.col_mut(i)[j] = entry;
        }
        turn * by * back
    }
}

/// `(½ ln a − ½ ln b)/(a − b) = artanh(q)/(q (a + b))`, `q = (a − b)/(a + b)`; 1/2a where a = b.
#[inline]
fn log_slope(a: f64, b: f64) -> f64 {
    let sum = a + b;
    let q = (a - b) / sum;
    let square = q * q;
    let ratio = if square < 1e-3 {
        1.0 + square * (1.0 / 3.0 + square * (0.2 + square * (1.0 / 7.0 + square * (1.0 / 9.0 + square / 11.0))))
    } else {
        q.atanh() / q
    };
    ratio / sum
}

/// `sinh(z)/z`.
#[inline]
fn sinh_over(z: f64) -> f64 {
    let square = z * z;
    if square < 1e-2 {
        1.0 + square / 6.0 * (1.0 + square / 20.0 * (1.0 + square / 42.0 * (1.0 + square / 72.0)))
    } else {
        z.sinh() / z
    }
}

/// Of what is not less than the least stretch 1, of what both are below it 0.
#[inline]
fn clamp_slope(values: DVec3, clamped: DVec3, i: usize, j: usize) -> f64 {
    match (values[i] == clamped[i], values[j] == clamped[j]) {
        (true, true) => 1.0,
        (false, false) => 0.0,
        _ => (clamped[i] - clamped[j]) / (values[i] - values[j]),
    }
}

#[cfg(test)]
mod tests {
    use super::super::spectrum::{LANES, Spectra};
    use super::*;
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn decompose(m: &DMat3) -> Spectrum {
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
        let material = Material { shear: 2.0, lame: 3.0, yields: 0.1 };
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
                    let (kept, stress) = material.flow(&trial, &decompose(&trial));
                    dot(&kept, &by_kept) + dot(&stress, &by_stress)
                };
                let h = 1e-6;
                let difference = (cost(h) - cost(-h)) / (2.0 * h);
                let spectrum = decompose(&at);
                let strains = material.strains(spectrum.values);
                let exact = dot(&material.pull(&spectrum, &strains, &by_kept, &by_stress), &direction);
                assert!(
                    (exact - difference).abs() < 1e-7 * (1.0 + exact.abs()),
                    "{diagonal:?}: {exact} against {difference}"
                );
            }
        }
    }

    #[test]
    fn flow_bears_so_much_shear_and_keeps_the_volume() {
        let material = Material { shear: 2.0, lame: 3.0, yields: 0.02 };
        let stretched = DMat3::from_diagonal(DVec3::new(1.4, 0.8, 1.1));
        let (kept, stress) = material.flow(&stretched, &decompose(&stretched));
        assert!((kept.determinant() - stretched.determinant()).abs() < 1e-13);
        let mean = (stress.x_axis.x + stress.y_axis.y + stress.z_axis.z) / 3.0;
        let shear = stress - DMat3::from_diagonal(DVec3::splat(mean));
        assert!((dot(&shear, &shear).sqrt() - 2.0 * 2.0 * 0.02).abs() < 1e-13);
        assert!((mean - (2.0 / 3.0 * 2.0 + 3.0) * 0.5 * stretched.determinant().ln()).abs() < 1e-13);
        let little = DMat3::from_diagonal(DVec3::new(1.01, 0.995, 1.0));
        assert_eq!(material.flow(&little, &decompose(&little)).0, little);
    }
}
