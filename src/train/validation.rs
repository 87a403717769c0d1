//! What training watches: the error on windows of training episodes that are never trained on.
use super::evaluate::errors;
use super::window::Window;
use crate::model::WorldModel;
use serde::Serialize;

/// Root mean square position errors on the validation windows \[m\].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Validation {
    /// After one step.
    pub(super) one_step: f64,
    /// After one step, if nothing moved.
    pub(super) still_one_step: f64,
    /// After the windows' last step; the weights with the lowest are the best.
    pub(super) rollout: f64,
    /// After the windows' last step, if nothing moved.
    pub(super) still_rollout: f64,
}

/// Scores a model on `windows`, or `None` when there are none.
pub(super) fn validate(model: &dyn WorldModel, windows: &[Window<'_>]) -> anyhow::Result<Option<Validation>> {
    let errors = errors(model, windows)?;
    let ends = |curve: &[f64]| curve.first().copied().zip(curve.last().copied());
    Ok(ends(&errors.curve).zip(ends(&errors.still)).map(|((one_step, rollout), (still_one_step, still_rollout))| {
        Validation { one_step, still_one_step, rollout, still_rollout }
    }))
}
