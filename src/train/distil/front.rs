//! Formulas that no simpler one beats, and which of them to believe.
use super::fitted::Fitted;

/// By growing complexity, each with a smaller error than all before it.
#[derive(Clone, Debug, Default)]
pub struct Front(Vec<Fitted>);

/// Errors below this are rounding, and alike.
pub(super) const EXACT: f64 = 1e-9;
/// How far above the smallest error the believed formula's may be: what PySR allows (Cranmer 2023, `model_selection = "best"`).
const NEAR: f64 = 1.5;

impl Front {
    /// The formulas.
    pub fn formulas(&self) -> &[Fitted] {
        &self.0
    }

    /// Takes a formula in, unless one that is no more complex is as good, and puts out those that it beats.
    pub(super) fn offer(&mut self, one: Fitted) {
        let error = |of: &Fitted| of.error.max(EXACT);
        let worse = |old: &Fitted| old.form.complexity > one.form.complexity || error(old) > error(&one);
        if self.0.iter().all(worse) {
            self.0.retain(|old| old.form.complexity < one.form.complexity || error(old) < error(&one));
            let place = self.0.partition_point(|old| old.form.complexity < one.form.complexity);
            self.0.insert(place, one);
        }
    }

    /// The formula where the logarithm of the error falls most steeply with complexity, `−Δ ln error/Δ complexity` from the one
    /// before it (Cranmer et al. 2020), among those whose `errors` are at most 1.5 times the smallest.
    pub(super) fn believed(&self, errors: &[f64]) -> Option<usize> {
        let least = errors.iter().copied().fold(f64::INFINITY, f64::min);
        let steepness = |k: usize| match k {
            0 => 0.0,
            _ => {
                let run = self.0[k].form.complexity - self.0[k - 1].form.complexity;
                (errors[k - 1].max(EXACT) / errors[k].max(EXACT)).ln() / run as f64
            }
        };
        let near = (0..self.0.len()).filter(|k| errors[*k].is_finite() && errors[*k] <= NEAR * least.max(EXACT));
        near.reduce(|best, k| if steepness(k) > steepness(best) { k } else { best })
    }
}
