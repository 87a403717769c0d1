//! What a fitted model predicts where an episode recorded what happened.
use super::Playback;
use crate::compare::{CompareSpec, fit};
use crate::metric::{MatchedRmse, Matching, Metric};
use crate::state::Rollout;
use crate::watch::Watch;
use anyhow::{Context, ensure};

/// A model's rollout from an episode's first frame under its tool's motion.
#[derive(Clone, Debug)]
pub struct Prediction {
    /// Name of the model.
    pub model: String,
    /// H + 1 states, the start included.
    pub rollout: Rollout,
}

impl Prediction {
    /// Fits the model `name` of a comparison, or reads what an earlier run has fitted, and rolls it out.
    ///
    /// # Errors
    /// When the comparison has no such model, the fit fails, the recording lacks its tool's shape, or the model cannot start from
    /// a recorded frame.
    pub fn of(recording: &Playback, name: &str, spec: &CompareSpec, watch: &Watch) -> anyhow::Result<Self> {
        let mut spec = spec.clone();
        let known = spec.model.keys().cloned().collect::<Vec<_>>().join(", ");
        spec.model.retain(|model, _| model == name);
        ensure!(!spec.model.is_empty(), "the comparison has no model `{name}`; it has {known}");
        let shape = recording.shape.as_ref().with_context(|| {
            let path = recording.path.display();
            format!("{path} lies in no dataset, so the shape of its tool is unknown, which a model must know")
        })?;
        let (contenders, _) = fit(&spec, watch)?;
        let contender = contenders.first().expect("one model was kept");
        let (episode, model) = (&recording.episode, &contender.model);
        let scene = episode.scene(0, shape);
        model.accepts(&scene).with_context(|| format!("`{name}` cannot start from a recorded frame"))?;
        Ok(Self { model: contender.name.clone(), rollout: model.rollout(&scene, &episode.controls) })
    }

    /// `√((1/N) Σᵢ |p̂ᵢ − pᵢ|²)` \[m\] of every frame, infinite where the model predicts what is no number.
    pub(super) fn errors(&self, recording: &Playback) -> Vec<f64> {
        let frames = self.rollout.iter().zip(&recording.episode.states);
        let error = frames.map(|(a, b)| MatchedRmse.evaluate(&a.positions, &b.positions, Matching::Matched));
        error.map(|e| e.unwrap_or(f64::INFINITY)).collect()
    }
}
