//! Adam on a flat vector, with moments that can be saved.
use serde::{Deserialize, Serialize};

/// Adam (Kingma & Ba 2015, algorithm 1) with β₁ = 0.9, β₂ = 0.999, ε = 1e-8.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Adam {
    /// m, the running mean of gradients.
    pub first: Vec<f32>,
    /// v, the running mean of squared gradients.
    pub second: Vec<f32>,
}

const BETA: [f64; 2] = [0.9, 0.999];

impl Adam {
    /// Before the first step, for `count` weights.
    pub fn new(count: usize) -> Self {
        Self { first: vec![0.0; count], second: vec![0.0; count] }
    }

    /// Step number `step` (the first is 1): `w ← w − rate · m̂ / (√v̂ + ε)`.
    pub fn step(&mut self, step: u64, weights: &mut [f32], gradient: &[f32], rate: f64) {
        let corrections = BETA.map(|b| (1.0 - b.powf(step as f64)).recip() as f32);
        let [b1, b2] = BETA.map(|b| b as f32);
        let moments = self.first.iter_mut().zip(&mut self.second);
        for ((w, g), (m, v)) in weights.iter_mut().zip(gradient).zip(moments) {
            *m = b1 * *m + (1.0 - b1) * g;
            *v = b2 * *v + (1.0 - b2) * g * g;
            *w -= rate as f32 * (*m * corrections[0]) / ((*v * corrections[1]).sqrt() + 1e-8);
        }
    }
}

/// Shortens `gradient` to the length `limit` if it is longer; returns the length it had.
pub(super) fn clip(gradient: &mut [f32], limit: f64) -> f64 {
    let norm = gradient.iter().map(|g| f64::from(*g).powi(2)).sum::<f64>().sqrt();
    if norm > limit {
        let factor = (limit / norm) as f32;
        gradient.iter_mut().for_each(|g| *g *= factor);
    }
    norm
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_step_has_the_length_of_the_rate_whatever_the_gradient() {
        let mut weights = vec![1.0, 1.0, 1.0];
        Adam::new(3).step(1, &mut weights, &[1e3, -1e-3, 0.0], 0.1);
        for (w, expected) in weights.iter().zip([0.9, 1.1, 1.0]) {
            assert!((w - expected).abs() < 1e-5, "{w} instead of {expected}");
        }
    }

    #[test]
    fn a_long_gradient_is_shortened_and_keeps_its_direction() {
        let mut gradient = vec![3.0, 4.0];
        assert_eq!(clip(&mut gradient, 1.0), 5.0);
        assert!((gradient[0] - 0.6).abs() < 1e-6 && (gradient[1] - 0.8).abs() < 1e-6);
        assert_eq!(clip(&mut gradient, 2.0), f64::from(gradient[0]).hypot(f64::from(gradient[1])));
        assert!((gradient[0] - 0.6).abs() < 1e-6, "a short gradient must stay");
    }
}
