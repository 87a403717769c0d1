//! How well a model predicts episodes, one step ahead and all the way.
use super::split::Tools;
use super::window::Window;
use super::windows::Windows;
use crate::data::Episode;
use crate::model::WorldModel;
use crate::state::Particles;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Root mean square position errors over particles and episodes \[m\]; infinite where a rollout was not finite.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Evaluation {
    /// Number of episodes.
    pub episodes: usize,
    /// One step ahead, from every true state of every episode \[m\].
    #[serde(deserialize_with = "number")]
    pub one_step: f64,
    /// The same if nothing ever moved \[m\].
    #[serde(deserialize_with = "number")]
    pub still_one_step: f64,
    /// After the last step of whole-episode rollouts from their starts \[m\].
    #[serde(deserialize_with = "number")]
    pub rollout: f64,
    /// The same if nothing ever moved \[m\].
    #[serde(deserialize_with = "number")]
    pub still_rollout: f64,
    /// The rollouts' error after 1 … H steps \[m\], H the shortest episode's length.
    #[serde(deserialize_with = "numbers")]
    pub curve: Vec<f64>,
    /// The same if nothing ever moved \[m\].
    #[serde(deserialize_with = "numbers")]
    pub still_curve: Vec<f64>,
    /// Number of rollouts that were not finite.
    pub not_finite: usize,
}

/// Scores `model` on `episodes`: one step from every state, and one rollout of each whole episode.
///
/// # Errors
/// As [`Windows::new`], when there are no episodes, or when the model does not accept a scene.
pub fn evaluate(model: &dyn WorldModel, episodes: &[Episode], tools: &Tools) -> anyhow::Result<Evaluation> {
    let horizon = episodes.iter().map(|e| e.controls.len()).min().unwrap_or(0);
    anyhow::ensure!(horizon > 0, "there is no episode to evaluate a model on");
    let one = errors(model, &Windows::new(episodes, tools, 1, 0.0)?.iter().collect::<Vec<_>>())?;
    let starts: Vec<_> = episodes.iter().map(|e| Window::of(e, 0, horizon, &tools[&e.tool])).collect();
    let far = errors(model, &starts)?;
    Ok(Evaluation {
        episodes: episodes.len(),
        one_step: one.curve[0],
        still_one_step: one.still[0],
        rollout: far.curve[horizon - 1],
        still_rollout: far.still[horizon - 1],
        curve: far.curve,
        still_curve: far.still,
        not_finite: one.not_finite + far.not_finite,
    })
}

/// Root mean square errors over windows and particles after 1 … K steps \[m\].
pub(super) struct Errors {
    /// The model's.
    pub(super) curve: Vec<f64>,
    /// Nothing moving.
    pub(super) still: Vec<f64>,
    /// Windows whose rollout was not finite.
    pub(super) not_finite: usize,
}

/// Rolls the model out over every window, in parallel; the windows have equal lengths.
pub(super) fn errors(model: &dyn WorldModel, windows: &[Window<'_>]) -> anyhow::Result<Errors> {
    windows.iter().try_for_each(|w| model.accepts(&w.scene))?;
    let each: Vec<(Vec<[f64; 2]>, usize)> = windows
        .par_iter()
        .map(|window| {
            let rollout = model.rollout(&window.scene, &window.controls);
            let start = &window.scene.particles;
            let rows = rollout[1..].iter().zip(&*window.targets);
            let sums = rows.map(|(x, y)| [squares(x, y), squares(start, y)]).collect();
            (sums, start.len())
        })
        .collect();
    let steps = windows.first().map_or(0, |w| w.targets.len());
    let count: usize = each.iter().map(|(_, n)| n).sum();
    let root = |which: usize| {
        (0..steps).map(|t| (each.iter().map(|(s, _)| s[t][which]).sum::<f64>() / count.max(1) as f64).sqrt()).collect()
    };
    let not_finite = each.iter().filter(|(s, _)| s.iter().any(|s| !s[0].is_finite())).count();
    Ok(Errors { curve: root(0), still: root(1), not_finite })
}

/// Sum of squared distances \[m²\], infinite if a prediction is not finite.
fn squares(x: &Particles, y: &Particles) -> f64 {
    let sum: f64 = x.positions.iter().zip(&y.positions).map(|(x, y)| x.distance_squared(*y)).sum();
    if x.is_finite() && sum.is_finite() { sum } else { f64::INFINITY }
}

/// JSON has no infinity: it is written as `null` and read back here.
fn number<'de, D: serde::Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(from)?.unwrap_or(f64::INFINITY))
}

fn numbers<'de, D: serde::Deserializer<'de>>(from: D) -> Result<Vec<f64>, D::Error> {
    let list: Vec<Option<f64>> = Vec::deserialize(from)?;
    Ok(list.into_iter().map(|x| x.unwrap_or(f64::INFINITY)).collect())
}
