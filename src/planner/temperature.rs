//! How strongly cheap samples outweigh dear ones.
use anyhow::ensure;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The temperature λ of the weights `wᵢ ∝ exp(−(Jᵢ − min J)/λ)`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum TemperatureSpec {
    /// The same in every round.
    Fixed {
        /// λ, in the cost's unit.
        value: f64,
    },
    /// In each round such that the effective number of samples `(Σw)²/Σw²` is a share of them.
    Adapted {
        /// The share.
        share: f64,
    },
}

impl TemperatureSpec {
    pub(super) fn check(&self) -> anyhow::Result<()> {
        match self {
            Self::Fixed { value } => {
                ensure!(*value > 0.0 && value.is_finite(), "planner.temperature.value must be positive, got {value}");
            }
            Self::Adapted { share } => {
                ensure!(*share > 0.0 && *share < 1.0, "planner.temperature.share must lie in (0, 1), got {share}");
            }
        }
        Ok(())
    }

    /// Weights of sum 1; none for costs that are not finite. All zero when no cost is finite.
    pub(super) fn weights(&self, costs: &[f64]) -> Vec<f64> {
        let least = costs.iter().copied().filter(|c| c.is_finite()).fold(f64::INFINITY, f64::min);
        if !least.is_finite() {
            return vec![0.0; costs.len()];
        }
        match self {
            Self::Fixed { value } => softmin(costs, least, *value),
            Self::Adapted { share } => {
                let finite = costs.iter().filter(|c| c.is_finite());
                let (count, most) = finite.fold((0.0, least), |(n, m): (f64, f64), c| (n + 1.0, m.max(*c)));
                let wanted = (share * count).max(1.0);
                // Equal costs weigh equally at any temperature.
                let spread = if most > least { most - least } else { 1.0 };
                // The effective number grows with λ: bisection between far too cold and far too hot.
                let (mut low, mut high) = (1e-9 * spread, 1e9 * spread);
                for _ in 0..80 {
                    let middle = (low * high).sqrt();
                    let squares: f64 = softmin(costs, least, middle).iter().map(|w| w * w).sum();
                    if squares.recip() < wanted { low = middle } else { high = middle }
                }
                softmin(costs, least, high)
            }
        }
    }
}

fn softmin(costs: &[f64], least: f64, temperature: f64) -> Vec<f64> {
    let raw = costs.iter().map(|c| if c.is_finite() { (-(c - least) / temperature).exp() } else { 0.0 });
    let raw: Vec<f64> = raw.collect();
    let sum: f64 = raw.iter().sum();
    raw.into_iter().map(|w| w / sum).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cold_weights_choose_the_cheapest_and_adapted_ones_the_share_that_counts() {
        let costs = [3.0, 1.0, f64::INFINITY, 1.5, 7.0, 2.0];
        let cold = TemperatureSpec::Fixed { value: 1e-6 }.weights(&costs);
        assert_eq!(cold, [0.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
        for scale in [1e-6, 1.0, 1e6] {
            let scaled = costs.map(|c| c * scale);
            for share in [0.3, 0.5, 0.8] {
                let weights = TemperatureSpec::Adapted { share }.weights(&scaled);
                let effective = weights.iter().map(|w| w * w).sum::<f64>().recip();
                assert!((effective - 5.0 * share).abs() < 1e-6, "{effective} of 5 with a share of {share}");
                assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12 && weights[2] == 0.0);
                assert!(weights[1] > weights[3] && weights[3] > weights[5] && weights[0] > weights[4]);
            }
        }
        assert_eq!(TemperatureSpec::Adapted { share: 0.5 }.weights(&[f64::INFINITY; 2]), [0.0; 2]);
        let equal = TemperatureSpec::Adapted { share: 0.5 }.weights(&[2.0; 4]);
        assert_eq!(equal, [0.25; 4]);
    }
}
