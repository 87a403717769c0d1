//! The config of a network of two clouds and of its training.
use anyhow::ensure;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A network that is shown a workpiece as it is and as it should be, and how its weights are fitted by gradient descent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PointNetSpec {
    /// Width of every hidden layer.
    #[schemars(range(min = 1))]
    pub width: usize,
    /// Length that counts as one \[m\]: about that of a workpiece.
    #[schemars(range(min = 1e-6))]
    pub extent: f64,
    /// Optimiser steps.
    #[schemars(range(min = 1))]
    pub steps: u64,
    /// Examples per step.
    #[schemars(range(min = 1))]
    pub batch: usize,
    /// Peak learning rate.
    #[schemars(range(min = 1e-8, max = 1.0))]
    pub rate: f64,
    /// Steps of linear warm-up.
    pub warm_up: u64,
    /// Learning rate of the last step as a fraction of the peak, reached along a cosine.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub last_rate: f64,
    /// Length beyond which a gradient is shortened.
    #[schemars(range(min = 1e-8))]
    pub clip: f64,
    /// Standard deviation of the noise added to every point of every example, drawn anew each time \[m\].
    #[schemars(range(min = 0.0))]
    pub noise: f64,
    /// Fraction of the examples, the last ones, that is not trained on but used to choose the best weights.
    #[schemars(range(min = 0.0, max = 0.9))]
    pub validation: f64,
    /// Steps between two validations, two lines of `metrics.jsonl` and two checkpoints.
    #[schemars(range(min = 1))]
    pub log_every: u64,
    /// Seed of weights, batches and noise.
    pub seed: u64,
}

impl Default for PointNetSpec {
    fn default() -> Self {
        Self {
            width: 64,
            extent: 0.05,
            steps: 2000,
            batch: 32,
            rate: 2e-3,
            warm_up: 50,
            last_rate: 0.02,
            clip: 5.0,
            noise: 5e-4,
            validation: 0.1,
            log_every: 100,
            seed: 0,
        }
    }
}

impl PointNetSpec {
    /// Checks the values.
    ///
    /// # Errors
    /// A sentence naming the key whose value is impossible.
    pub(in crate::train) fn check(&self) -> anyhow::Result<()> {
        let counts = [
            ("width", self.width as u64),
            ("steps", self.steps),
            ("batch", self.batch as u64),
            ("log_every", self.log_every),
        ];
        for (key, value) in counts {
            ensure!(value > 0, "`network.{key}` is 0; give at least 1");
        }
        let ranges = [
            ("extent", self.extent, 1e-6, f64::MAX),
            ("rate", self.rate, 1e-8, 1.0),
            ("last_rate", self.last_rate, 0.0, 1.0),
            ("clip", self.clip, 1e-8, f64::INFINITY),
            ("noise", self.noise, 0.0, f64::MAX),
            ("validation", self.validation, 0.0, 0.9),
        ];
        for (key, value, low, high) in ranges {
            ensure!((low..=high).contains(&value), "`network.{key}` is {value}; give a number from {low} to {high}");
        }
        Ok(())
    }
}
