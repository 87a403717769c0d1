//! How well each model predicts held-out episodes.
use super::Contender;
use crate::train::Evaluation;
use serde::{Deserialize, Serialize};

/// One model's errors on episodes that no fit has seen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Prediction {
    /// Model name.
    pub model: String,
    /// Its errors, beside those of a model in which nothing moves.
    pub held_out: Evaluation,
}

impl Prediction {
    /// Of a contender, unless it cannot start from a recorded frame.
    pub fn of(contender: &Contender) -> Option<Self> {
        Some(Self { model: contender.name.clone(), held_out: contender.held_out.clone()? })
    }
}
