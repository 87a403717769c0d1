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

    /// The fractions of the box at which `theta` lies; a half along an axis without room.
    pub fn unit(&self, theta: &[f64]) -> Vec<f64> {
        let place = |((x, low), high): ((&f64, &f64), &f64)| if high > low { (x - low) / (high - low) } else { 0.5 };
        theta.iter().zip(&self.low).zip(&self.high).map(place).collect()
    }

    /// `∂J/∂u` from `∂J/∂θ` for fractions u of the box.
    pub fn by_unit(&self, gradient: &[f64]) -> Vec<f64> {
        gradient.iter().zip(self.low.iter().zip(&self.high)).map(|(g, (low, high))| g * (high - low)).collect()
    }

    /// Whether `theta` has the box's dimension and lies inside it.
    pub fn contains(&self, theta: &[f64]) -> bool {
        theta.len() == self.dimension()
            && theta.iter().zip(self.low.iter().zip(&self.high)).all(|(x, (low, high))| low <= x && x <= high)
    }

    /// Accepts what a user typed as θ only if it lies in the box.
    ///
    /// # Errors
    /// A sentence naming the count of coordinates, or the first coordinate outside, its value and its bounds.
    pub fn check(&self, theta: &[f64]) -> anyhow::Result<()> {
        anyhow::ensure!(
            theta.len() == self.dimension(),
            "the action has {} numbers, this tool takes {}: {}",
            theta.len(),
            self.dimension(),
            self.names.join(", ")
        );
        for (i, x) in theta.iter().enumerate() {
            anyhow::ensure!(
                self.low[i] <= *x && *x <= self.high[i],
                "the action's `{}` is {x}, outside its bounds: choose a value from {} to {}",
                self.names[i],
                self.low[i],
                self.high[i]
            );
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_theta_outside_is_refused_with_its_name_value_and_bounds() {
        let space =
            ActionSpace { names: vec!["r".into(), "width".into()], low: vec![-0.02, 0.001], high: vec![0.02, 0.04] };
        assert!(space.check(&[0.02, 0.001]).is_ok());
        let sentence = |theta: &[f64]| space.check(theta).unwrap_err().to_string();
        for (theta, words) in [
            (&[0.0, 0.05][..], ["`width`", "0.05", "0.001", "0.04"]),
            (&[f64::NAN, 0.01], ["`r`", "NaN", "-0.02", "0.02"]),
            (&[0.0], ["has 1 number", "takes 2", "r", "width"]),
        ] {
            assert!(words.iter().all(|w| sentence(theta).contains(w)), "{}", sentence(theta));
        }
    }
}
