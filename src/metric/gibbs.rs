//! A Gibbs kernel around given potentials, sparse where it is negligible.
use super::softmin::{LANES, Lanes, TASK, counts, exp, exponents, grouped};
use glam::DVec3;
use rayon::prelude::*;

/// `K_ij = exp((fᵢ + gⱼ − |xᵢ − yⱼ|)/ε)/M`, kept where it is above e⁻⁴⁰ (Schmitzer 2019, section 3.3), in groups of eight columns.
///
/// Iterations with it are products and quotients alone. What is left out matters only when potentials have moved by tens of ε
/// since, so [`super::transport`] makes a new kernel long before that.
pub(super) struct Gibbs {
    /// For each row its groups: number of the group and its eight entries.
    rows: Vec<Vec<(usize, Lanes)>>,
    /// Number of groups of columns.
    groups: usize,
}

impl Gibbs {
    /// The kernel between `x` and `y` around potentials `f` and `g` \[m\].
    pub(super) fn around(x: &[DVec3], f: &[f64], y: &[[Lanes; 3]], g: &[f64], epsilon: f64) -> Self {
        let scaled = grouped(g.iter().map(|g| g / epsilon), f64::NEG_INFINITY);
        let columns = (g.len() as f64).ln();
        let mut rows = vec![Vec::new(); x.len()];
        rows.par_chunks_mut(TASK).zip(x.par_chunks(TASK).zip(f.par_chunks(TASK))).for_each(|(rows, (x, f))| {
            let mut z = grouped(std::iter::repeat_n(0.0, g.len()), 0.0);
            for (row, (x, f)) in rows.iter_mut().zip(x.iter().zip(f)) {
                exponents(*x, y, &scaled, 1.0 / epsilon, &mut z);
                let kept = z.iter().enumerate().filter(|(_, z)| counts(z, -f / epsilon));
                row.extend(kept.map(|(group, z)| (group, exp(z, columns - f / epsilon))));
            }
        });
        Self { rows, groups: scaled.len() }
    }

    /// `Σⱼ K_ij vⱼ` for every i.
    pub(super) fn rows(&self, v: &[f64]) -> Vec<f64> {
        let v = grouped(v.iter().copied(), 0.0);
        let sum = |row: &Vec<(usize, Lanes)>| {
            let mut sum = [0.0; LANES];
            for (group, entries) in row {
                for (l, sum) in sum.iter_mut().enumerate() {
                    *sum += entries[l] * v[*group][l];
                }
            }
            sum.iter().sum()
        };
        self.rows.iter().map(sum).collect()
    }

    /// `Σᵢ K_ij uᵢ` for every j, filled up to whole groups.
    pub(super) fn columns(&self, u: &[f64]) -> Vec<Lanes> {
        let mut sums = grouped(std::iter::repeat_n(0.0, LANES * self.groups), 0.0);
        for (row, u) in self.rows.iter().zip(u) {
            for (group, entries) in row {
                for (sum, entry) in sums[*group].iter_mut().zip(entries) {
                    *sum += entry * u;
                }
            }
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metric::softmin::grouped_points;
    use crate::metric::tests::cloud;

    #[test]
    fn its_products_are_those_of_the_full_matrix() {
        let (x, y) = (cloud(21, 1), cloud(13, 2));
        let numbers = |count, purpose| cloud(count, purpose).iter().map(|p| 0.3 * p.x).collect::<Vec<f64>>();
        let (f, g, u, v) = (numbers(21, 3), numbers(13, 4), numbers(21, 5), numbers(13, 6));
        for epsilon in [0.3, 0.01] {
            let full = |i: usize, j: usize| ((f[i] + g[j] - x[i].distance(y[j])) / epsilon).exp() / 13.0;
            let kernel = Gibbs::around(&x, &f, &grouped_points(&y), &g, epsilon);
            for (i, found) in kernel.rows(&v).into_iter().enumerate() {
                let expected: f64 = (0..13).map(|j| full(i, j) * v[j]).sum();
                assert!((found - expected).abs() < 1e-13 * expected + 1e-16, "{found} against {expected}");
            }
            for (j, found) in kernel.columns(&u).as_flattened()[..13].iter().enumerate() {
                let expected: f64 = (0..21).map(|i| full(i, j) * u[i]).sum();
                assert!((found - expected).abs() < 1e-13 * expected + 1e-16, "{found} against {expected}");
            }
        }
    }
}
