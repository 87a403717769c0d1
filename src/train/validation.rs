//! What training watches: the error on windows of training episodes that are never trained on.
use super::evaluate::errors;
use super::window::Window;
use crate::metric::ShapeLoss;
use crate::model::WorldModel;
use rayon::prelude::*;
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
    /// Mean distance of shapes after the windows' last step \[m\], where training minimises one: then the weights with the lowest are
    /// the best.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) shape: Option<f64>,
}

/// Scores a model on `windows`, or `None` when there are none.
pub(super) fn validate(
    model: &dyn WorldModel,
    windows: &[Window<'_>],
    loss: Option<&dyn ShapeLoss>,
) -> anyhow::Result<Option<Validation>> {
    let errors = errors(model, windows)?;
    let distance = |loss: &dyn ShapeLoss| {
        let last = |w: &Window<'_>| {
            let end = model.rollout(&w.scene, &w.controls).pop().unwrap_or_default();
            loss.value(&end.positions, &w.targets[w.targets.len() - 1].positions)
        };
        windows.par_iter().map(last).collect::<Vec<_>>().iter().sum::<f64>() / windows.len() as f64
    };
    let shape = loss.map(distance);
    let ends = |curve: &[f64]| curve.first().copied().zip(curve.last().copied());
    Ok(ends(&errors.curve).zip(ends(&errors.still)).map(|((one_step, rollout), (still_one_step, still_rollout))| {
        Validation { one_step, still_one_step, rollout, still_rollout, shape }
    }))
}
