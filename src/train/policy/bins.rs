//! Numbers as bins and residuals: a distribution that may have several peaks, and a place within each of its cells.

/// How a coordinate in \[0, 1\] is told: which of equal cells, and where in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bins {
    /// Number of cells.
    pub count: usize,
}

impl Bins {
    /// The cell k of `u`, and its distance from the cell's middle in cells, r ∈ \[−½, ½\].
    pub fn encode(&self, u: f64) -> (usize, f64) {
        let place = u.clamp(0.0, 1.0) * self.count as f64;
        let cell = (place as usize).min(self.count - 1);
        (cell, place - cell as f64 - 0.5)
    }

    /// `u = (k + ½ + r)/count`, kept in \[0, 1\].
    pub fn decode(&self, cell: usize, residual: f64) -> f64 {
        ((cell as f64 + 0.5 + residual) / self.count as f64).clamp(0.0, 1.0)
    }

    /// Numbers that say a coordinate: a logit and a residual a cell.
    pub(super) fn outputs(&self) -> usize {
        2 * self.count
    }
}

/// Natural logarithms of the probabilities that logits stand for.
pub(in crate::train) fn log_softmax(logits: &[f32]) -> Vec<f64> {
    let most = logits.iter().fold(f64::NEG_INFINITY, |m, x| m.max(f64::from(*x)));
    let total = logits.iter().map(|x| (f64::from(*x) - most).exp()).sum::<f64>().ln() + most;
    logits.iter().map(|x| f64::from(*x) - total).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decoding_undoes_encoding_and_residuals_stay_in_their_cell() {
        for count in [1, 2, 7, 12] {
            let bins = Bins { count };
            for i in 0..=1000 {
                let u = f64::from(i) / 1000.0;
                let (cell, residual) = bins.encode(u);
                assert!(cell < count && residual.abs() <= 0.5 + 1e-12, "{u}: {cell} {residual}");
                assert!((bins.decode(cell, residual) - u).abs() < 1e-12, "{u}");
            }
        }
        assert_eq!(Bins { count: 4 }.decode(3, 9.0), 1.0, "no residual leaves the box");
    }

    #[test]
    fn probabilities_sum_to_one_however_large_the_logits() {
        let log = log_softmax(&[1000.0, 999.0, -1000.0]);
        assert!((log.iter().map(|l| l.exp()).sum::<f64>() - 1.0).abs() < 1e-12);
        assert!((log[0] - log[1] - 1.0).abs() < 1e-12);
    }
}
