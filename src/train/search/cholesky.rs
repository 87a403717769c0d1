//! The Cholesky factor of a symmetric positive definite matrix.

/// `K = L Lᵀ`, the lower triangle row by row.
pub(in crate::train) struct Cholesky(Vec<Vec<f64>>);

impl Cholesky {
    /// Of the matrix whose lower rows `entry` gives, or `None` where it is not positive definite.
    pub(in crate::train) fn new(count: usize, entry: impl Fn(usize, usize) -> f64) -> Option<Self> {
        let mut rows: Vec<Vec<f64>> = Vec::with_capacity(count);
        for i in 0..count {
            let mut row: Vec<f64> = Vec::with_capacity(i + 1);
            for (j, other) in rows.iter().enumerate() {
                let sum: f64 = row.iter().zip(other).take(j).map(|(a, b)| a * b).sum();
                row.push((entry(i, j) - sum) / other[j]);
            }
            let rest = entry(i, i) - row.iter().map(|a| a * a).sum::<f64>();
            if rest.is_nan() || rest <= 0.0 {
                return None;
            }
            row.push(rest.sqrt());
            rows.push(row);
        }
        Some(Self(rows))
    }

    /// x of `L x = b`.
    pub(in crate::train) fn forward(&self, b: &[f64]) -> Vec<f64> {
        let mut x: Vec<f64> = Vec::with_capacity(b.len());
        for (row, b) in self.0.iter().zip(b) {
            let sum: f64 = row.iter().zip(&x).map(|(l, x)| l * x).sum();
            x.push((b - sum) / row[x.len()]);
        }
        x
    }

    /// x of `Lᵀ x = b`.
    pub(in crate::train) fn backward(&self, mut b: Vec<f64>) -> Vec<f64> {
        for i in (0..b.len()).rev() {
            b[i] /= self.0[i][i];
            let x = b[i];
            b.iter_mut().zip(&self.0[i]).take(i).for_each(|(b, l)| *b -= l * x);
        }
        b
    }

    /// `ln det K`.
    pub(super) fn log_determinant(&self) -> f64 {
        self.0.iter().enumerate().map(|(i, row)| 2.0 * row[i].ln()).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_solves_undo_the_matrix() {
        let a = [[4.0, 1.0, 0.5], [1.0, 3.0, -0.7], [0.5, -0.7, 2.0]];
        let factor = Cholesky::new(3, |i, j| a[i][j]).unwrap();
        let x = [0.3, -2.0, 1.5];
        let b: Vec<f64> = a.iter().map(|row| row.iter().zip(x).map(|(a, x)| a * x).sum()).collect();
        let found = factor.backward(factor.forward(&b));
        assert!(found.iter().zip(x).all(|(a, b)| (a - b).abs() < 1e-14), "{found:?}");
        let determinant: f64 = 4.0 * (6.0 - 0.49) - 1.0 * (2.0 + 0.35) + 0.5 * (-0.7 - 1.5);
        assert!((factor.log_determinant() - determinant.ln()).abs() < 1e-13);
        assert!(Cholesky::new(2, |i, j| if i == j { 1.0 } else { 2.0 }).is_none(), "it is not positive definite");
    }
}
