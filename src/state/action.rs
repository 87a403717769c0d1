//! The box that actions live in.
use serde::{Deserialize, Serialize};

/// An axis-aligned box in ℝᵈ: `low[i] ≤ θ[i] ≤ high[i]`, each coordinate in its own unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ActionSpace {
    /// Names of the coordinates, for tables and errors.
    pub names: Vec<String>,
    /// Lower bounds.
    pub low: Vec<f64>,
    /// Upper bounds.
    pub high: Vec<f64>,
}

impl ActionSpace {
    /// Number of coordinates d.
    pub fn dimension(&self) -> usize {
        self.low.len()
    }

    /// Moves `theta` to the nearest point of the box.
    pub fn clamp(&self, theta: &mut [f64]) {
        for ((x, low), high) in theta.iter_mut().zip(&self.low).zip(&self.high) {
            *x = x.clamp(*low, *high);
        }
    }

    /// The point at fractions `unit` ∈ \[0, 1\]ᵈ of the box.
    pub fn at(&self, unit: &[f64]) -> Vec<f64> {
        unit.iter().zip(self.low.iter().zip(&self.high)).map(|(u, (low, high))| low + u * (high - low)).collect()
    }

    /// Whether `theta` has the box's dimension and lies inside it.
    pub fn contains(&self, theta: &[f64]) -> bool {
        theta.len() == self.dimension()
            && theta.iter().zip(self.low.iter().zip(&self.high)).all(|(x, (low, high))| low <= x && x <= high)
    }
}
