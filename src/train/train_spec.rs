//! The config of a training run.
use super::trainer::Trainer;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How weights are fitted by gradient descent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TrainSpec {
    /// Optimiser steps.
    #[schemars(range(min = 1))]
    pub steps: u64,
    /// Windows per step.
    #[schemars(range(min = 1))]
    pub batch: usize,
    /// Control steps that a window is rolled out for, each counting equally in the loss.
    #[schemars(range(min = 1))]
    pub horizon: usize,
    /// Peak learning rate.
    #[schemars(range(min = 1e-8, max = 1.0))]
    pub rate: f64,
    /// Steps of linear warm-up.
    pub warm_up: u64,
    /// Learning rate of the last step as a fraction of the peak, reached along a cosine.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub last_rate: f64,
    /// Greatest angle by which a window is turned at random about the vertical, which no law of the world notices \[rad\].
    #[schemars(range(min = 0.0, max = std::f64::consts::PI))]
    pub turn: f64,
    /// Standard deviation of the random walk added to a window's start, the targets staying true \[m\].
    #[schemars(range(min = 0.0))]
    pub noise: f64,
    /// Length beyond which a gradient is shortened.
    #[schemars(range(min = 1e-8))]
    pub clip: f64,
    /// Fraction of a batch drawn only from windows in which something moves.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub moving: f64,
    /// Displacement per control step above which a particle counts as moving \[m\].
    #[schemars(range(min = 0.0))]
    pub motion: f64,
    /// Fraction of the training episodes of each tool that is not trained on but used to choose the best weights.
    #[schemars(range(min = 0.0, max = 0.9))]
    pub validation: f64,
    /// Windows of those episodes that are looked at.
    pub validation_windows: usize,
    /// Control steps of a validation window; the error after the last is what the best weights are chosen by.
    #[schemars(range(min = 1))]
    pub validation_horizon: usize,
    /// Steps between two validations.
    #[schemars(range(min = 1))]
    pub validate_every: u64,
    /// Steps between two lines of `metrics.jsonl`, and between two checkpoints.
    #[schemars(range(min = 1))]
    pub log_every: u64,
    /// Which weights are the result.
    pub keep: Keep,
    /// Path into the model's config of the key that is to name the file of trained weights.
    pub weights: String,
    /// Seed of batches and noise.
    pub seed: u64,
}

/// Which weights are the result of a training run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Keep {
    /// Those with the lowest validation error; the last where there was no validation.
    Best,
    /// Those after the last step.
    Last,
}

impl TrainSpec {
    /// Checks the values.
    ///
    /// # Errors
    /// A sentence naming the key whose value is impossible.
    pub fn build(self) -> anyhow::Result<Trainer> {
        let counts = [
            ("steps", self.steps),
            ("batch", self.batch as u64),
            ("horizon", self.horizon as u64),
            ("validation_horizon", self.validation_horizon as u64),
            ("validate_every", self.validate_every),
            ("log_every", self.log_every),
        ];
        for (key, value) in counts {
            anyhow::ensure!(value > 0, "`{key}` of the training config is 0; give at least 1");
        }
        let ranges = [
            ("rate", self.rate, 1e-8, 1.0),
            ("last_rate", self.last_rate, 0.0, 1.0),
            ("turn", self.turn, 0.0, std::f64::consts::PI),
            ("noise", self.noise, 0.0, f64::MAX),
            ("clip", self.clip, 1e-8, f64::INFINITY),
            ("moving", self.moving, 0.0, 1.0),
            ("motion", self.motion, 0.0, f64::MAX),
            ("validation", self.validation, 0.0, 0.9),
        ];
        for (key, value, low, high) in ranges {
            let inside = low <= value && value <= high;
            anyhow::ensure!(inside, "`{key}` of the training config is {value}; give a number from {low} to {high}");
        }
        Ok(Trainer { spec: self })
    }
}
