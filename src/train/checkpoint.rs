//! Where a fit stands: everything that the next step depends on, in one file that is written whole.
use super::adam::Adam;
use crate::config::write_whole;
use anyhow::Context;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::io::ErrorKind;
use std::path::Path;

/// A training run after some steps; random numbers need no place in it, each step has its own stream.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Checkpoint {
    /// Steps done.
    pub(super) step: u64,
    /// Weights after them.
    pub(super) weights: Vec<f32>,
    /// The optimiser's moments.
    pub(super) adam: Adam,
    /// The best weights so far.
    pub(super) best: Option<Best>,
    /// Steps, sum of losses and sum of gradient norms since the last log point.
    pub(super) since: (u64, f64, f64),
    /// Time spent \[s\].
    pub(super) seconds: f64,
}

/// The weights with the lowest validation error.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Best {
    /// Their error \[m\].
    pub(super) error: f64,
    /// The step after which they were reached.
    pub(super) step: u64,
    /// The weights.
    pub(super) weights: Vec<f32>,
}

impl Checkpoint {
    /// Before the first step.
    pub(super) fn new(weights: Vec<f32>) -> Self {
        let adam = Adam::new(weights.len());
        Self { step: 0, weights, adam, best: None, since: (0, 0.0, 0.0), seconds: 0.0 }
    }
}

/// Reads what [`save`] wrote, or `None` where there is nothing yet.
///
/// # Errors
/// When the file is damaged, or was made by a run of another `identity`.
pub(super) fn load<T: DeserializeOwned>(path: &Path, identity: &str) -> anyhow::Result<Option<T>> {
    let bytes = match std::fs::read(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        read => read.with_context(|| format!("cannot read {}", path.display()))?,
    };
    let damaged = || format!("{} is damaged; remove it to start over", path.display());
    let (made_by, rest): (String, _) = postcard::take_from_bytes(&bytes).with_context(damaged)?;
    anyhow::ensure!(
        made_by == identity,
        "{} belongs to a run with another config, model or data; remove its folder to start over, or name another",
        path.display()
    );
    postcard::from_bytes(rest).map(Some).with_context(damaged)
}

/// Writes `identity` and `state`, whole.
pub(super) fn save<T: Serialize>(path: &Path, identity: &str, state: &T) -> anyhow::Result<()> {
    let bytes = postcard::to_stdvec(&(identity, state));
    write_whole(path, &bytes.with_context(|| format!("cannot prepare {}", path.display()))?)
}
