//! What a fitted model predicts where an episode recorded what happened.
use super::Playback;
use crate::compare::Contender;
use crate::metric::{MatchedRmse, Matching, Metric};
use crate::state::Rollout;
use anyhow::Context;

/// A model's rollout from an episode's first frame under its tool's motion.
#[derive(Clone, Debug)]
pub struct Prediction {
    /// Name of the model.
    pub model: String,
    /// H + 1 states, the start included.
    pub rollout: Rollout,
}

impl Prediction {
    /// Rolls out what `fitted` gives, which is asked only where the recording can be predicted.
    ///
    /// # Errors
    /// When the recording lacks its tool's shape, the fit fails, or the model cannot start from a recorded frame.
    pub fn of(recording: &Playback, fitted: impl FnOnce() -> anyhow::Result<Contender>) -> anyhow::Result<Self> {
        let shape = recording.shape.as_ref().with_context(|| {
            let path = recording.path.display();
            format!("{path} lies in no dataset, so the shape of its tool is unknown, which a model must know")
        })?;
        let Contender { name, model, .. } = fitted()?;
        let scene = recording.episode.scene(0, shape);
        model.accepts(&scene).with_context(|| format!("`{name}` cannot start from a recorded frame"))?;
        let rollout = model.rollout(&scene, &recording.episode.controls);
        Ok(Self { model: name, rollout })
    }

    /// `√((1/N) Σᵢ |p̂ᵢ − pᵢ|²)` \[m\] of every frame, infinite where the model predicts what is no number.
    pub(super) fn errors(&self, recording: &Playback) -> Vec<f64> {
        let frames = self.rollout.iter().zip(&recording.episode.states);
        let error = frames.map(|(a, b)| MatchedRmse.evaluate(&a.positions, &b.positions, Matching::Matched));
        error.map(|e| e.unwrap_or(f64::INFINITY)).collect()
    }
}
