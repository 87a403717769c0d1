//! The config of a training run.
use super::Unroll;
use super::trainer::Trainer;
use crate::metric::CostSpec;
use anyhow::Context;
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
    /// Steps over which a window grows from one control step to `horizon`; with 0 it has them all from the first.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub grow: u64,
    /// Which control steps of a window are differentiated.
    #[serde(default, skip_serializing_if = "Unroll::is_whole")]
    pub unroll: Unroll,
    /// A distance between shapes to minimise where rows are not the same particles in every state; absent, the squared distance of
    /// each particle from where it should be.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub loss: Option<CostSpec>,
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
    /// Validations in a row without a lower error than the lowest before, after which training ends; absent, it never does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1))]
    pub patience: Option<u64>,
    /// Steps between two lines of `metrics.jsonl`, and between two checkpoints.
    #[schemars(range(min = 1))]
    pub log_every: u64,
    /// Weight of the mean of |N| + |T| over the messages at a window's start, by which what data do not ask for dies
    /// (Cranmer et al. 2020) \[s²/m\].
    #[serde(default, skip_serializing_if = "nothing")]
    #[schemars(range(min = 0.0))]
    pub sparsity: f64,
    /// Layers that learn, each by its name in the file of weights or by the beginning of that up to a dot, such as `round.0`; the others
    /// stay as they are. All learn where none is named.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub layers: Vec<String>,
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

fn nothing(weight: &f64) -> bool {
    *weight == 0.0
}

fn is_zero(count: &u64) -> bool {
    *count == 0
}

impl TrainSpec {
    /// Control steps of a window in optimiser step `step` ∈ 1..=`steps`.
    pub(super) fn length_at(&self, step: u64) -> usize {
        match self.grow {
            0 => self.horizon,
            // Equal shares of the growing for every length.
            grow => self.horizon.min(1 + ((step - 1) * self.horizon as u64 / grow) as usize),
        }
    }

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
            ("patience", self.patience.unwrap_or(1)),
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
            ("sparsity", self.sparsity, 0.0, f64::MAX),
        ];
        for (key, value, low, high) in ranges {
            let inside = low <= value && value <= high;
            anyhow::ensure!(inside, "`{key}` of the training config is {value}; give a number from {low} to {high}");
        }
        for (key, off) in [("validation", self.validation == 0.0), ("validation_windows", self.validation_windows == 0)]
        {
            anyhow::ensure!(
                self.patience.is_none() || !off,
                "`patience` of the training config counts validations, and with `{key}` = 0 there are none; raise `{key}` or leave \
                 `patience` out"
            );
        }
        let loss = self.loss.clone().map(CostSpec::build).transpose().context("in `loss` of the training config")?;
        anyhow::ensure!(
            loss.is_none_or(|loss| loss.has_gradient()),
            "`loss` of the training config has no gradient to train by; name a distance, such as {{ kind = \"chamfer\" }}"
        );
        Ok(Trainer { spec: self })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_window_grows_evenly_to_its_horizon() {
        let spec = json(r#"{ "horizon": 4, "grow": 100 }"#);
        let lengths: Vec<usize> = [1, 25, 26, 50, 51, 76, 100, 400].map(|step| spec.length_at(step)).to_vec();
        assert_eq!(lengths, [1, 1, 2, 2, 3, 4, 4, 4]);
        assert_eq!(json(r#"{ "horizon": 4 }"#).length_at(1), 4);
    }

    /// The shipped config with these changes.
    fn json(changes: &str) -> TrainSpec {
        let text = include_str!("../../configs/train/network.toml");
        let mut spec: serde_json::Value = toml_edit::de::from_str(text).unwrap();
        spec.as_object_mut().unwrap().shift_remove("kind");
        let changes: serde_json::Value = serde_json::from_str(changes).unwrap();
        spec.as_object_mut().unwrap().extend(changes.as_object().unwrap().clone());
        serde_json::from_value(spec).unwrap()
    }
}
