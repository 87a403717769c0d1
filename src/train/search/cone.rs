//! What constants may be beside each other.

/// `|(cᵢ)ᵢ∈of| ≤ factor · c_axis` of constants c: a second-order cone; of a single i an order between two constants.
#[derive(Clone, Debug, PartialEq)]
pub struct Cone {
    /// The constant that bounds.
    pub axis: usize,
    /// Those that are bounded together.
    pub of: Vec<usize>,
    /// How many times the axis.
    pub factor: f64,
}

/// Share by which rounding may carry a solver's answer beyond a cone.
const ROUNDING: f64 = 1e-7;

impl Cone {
    /// Whether `constants` lie in it, but for rounding.
    pub fn holds(&self, constants: &[f64]) -> bool {
        let length = self.of.iter().map(|i| constants[*i].powi(2)).sum::<f64>().sqrt();
        length <= (1.0 + ROUNDING) * self.factor * constants[self.axis]
    }

    /// What must lie in the standard cone `|s₁…| ≤ s₀` at relative changes d of `constants`, in units of the axis: for each row the
    /// number of its d, and its value at d = 0, which is also its slope.
    pub fn rows(&self, constants: &[f64]) -> Vec<(usize, f64)> {
        let beside = self.of.iter().map(|i| (*i, constants[*i] / constants[self.axis]));
        std::iter::once((self.axis, self.factor)).chain(beside).collect()
    }
}
