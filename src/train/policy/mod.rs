//! A policy: the action of one tool that a model would need to turn a workpiece into its goal, learned from the model's own rollouts.
mod bins;
mod imagined;

pub use bins::Bins;

pub(super) use bins::log_softmax;

use super::point_net::{Clouds, Lesson, PointNetSpec, said, taught};
use crate::data::Episode;
use crate::model::WorldModel;
use crate::model::net::PointNet;
use crate::state::ActionSpace;
use crate::tool::Tool;
use crate::watch::Watch;
use anyhow::ensure;
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// How policies are learned, one a model and tool.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PolicySpec {
    /// Cells that each coordinate of an action is told by.
    #[schemars(range(min = 1))]
    pub bins: usize,
    /// Actions of each tool that the model rolls out, divided among the first states of the training episodes.
    #[schemars(range(min = 2))]
    pub samples: usize,
    /// The network.
    pub network: PointNetSpec,
}

impl Default for PolicySpec {
    fn default() -> Self {
        Self { bins: 10, samples: 2000, network: PointNetSpec::default() }
    }
}

/// Weight of squared residuals \[cells²\] beside the logarithm of a cell's probability.
const RESIDUAL: f64 = 4.0;

/// A network that maps a workpiece and its goal to actions of one tool: for each coordinate logits over [`Bins`] and a residual in each
/// (RoboCook, Shi et al. 2023).
#[derive(Clone, Debug)]
pub struct Policy {
    net: PointNet,
    bins: Bins,
    extent: f64,
}

impl PolicySpec {
    /// Whether a config may leave the key out.
    pub(crate) fn is_default(&self) -> bool {
        *self == Self::default()
    }

    /// The policy of `tool` under `model`, learned from rollouts of random actions in `steps` control steps from the first states of
    /// `starts`, or as an earlier run left it in `folder`; `None` where the model cannot start from a recording or moves nothing.
    ///
    /// # Errors
    /// An impossible value, a fit that fails, a file that cannot be written, or a stop that was asked for.
    pub fn fit(
        &self,
        model: &dyn WorldModel,
        tool: &dyn Tool,
        starts: &[Episode],
        steps: usize,
        folder: &Path,
        watch: &Watch,
    ) -> anyhow::Result<Option<Policy>> {
        ensure!(self.bins >= 1, "`policy.bins` must be at least 1");
        ensure!(
            self.samples >= 2,
            "`policy.samples` must be at least 2: one to learn from and one to choose weights by"
        );
        let (bins, extent) = (Bins { count: self.bins }, self.network.extent);
        let Some(dimension) = imagined::dimension(model, tool, starts, steps) else { return Ok(None) };
        let loss = |row: &[f32], target: &Vec<f64>| loss(bins, row, target);
        let lesson = || {
            let examples = imagined::examples(self, model, tool, starts, steps, watch)?;
            Ok(examples.map(|examples| Lesson { examples, loss: &loss, turn: 0.0 }))
        };
        let net = taught(&self.network, dimension * bins.outputs(), lesson, folder, watch)?;
        Ok(net.map(|net| Policy { net, bins, extent }))
    }
}

/// `Σ −ln p(k) + w (r̂ₖ − r)²` over coordinates of the action, and its derivative by what the network says.
fn loss(bins: Bins, row: &[f32], target: &[f64]) -> (f64, Vec<f32>) {
    let (mut total, mut at) = (0.0, Vec::with_capacity(row.len()));
    for (own, u) in row.chunks_exact(bins.outputs()).zip(target) {
        let (logits, residuals) = own.split_at(bins.count);
        let (cell, residual) = bins.encode(*u);
        let log = log_softmax(logits);
        let gap = f64::from(residuals[cell]) - residual;
        total += RESIDUAL * gap * gap - log[cell];
        at.extend(log.iter().enumerate().map(|(k, l)| (l.exp() - f64::from(u8::from(k == cell))) as f32));
        at.extend((0..bins.count).map(|k| if k == cell { (2.0 * RESIDUAL * gap) as f32 } else { 0.0 }));
    }
    (total, at)
}

impl Policy {
    /// At most `most` actions in the box `space` that may turn `current` into `goal` \[m\], the most probable first.
    pub fn propose(&self, current: &[DVec3], goal: &[DVec3], space: &ActionSpace, most: usize) -> Vec<Vec<f64>> {
        let row = said(&self.net, &[&Clouds::new(current, goal, self.extent)]);
        // Coordinates are independent, so the best combinations of all begin with the best of the first ones.
        let mut best: Vec<(f64, Vec<f64>)> = vec![(0.0, Vec::new())];
        for own in row.chunks_exact(self.bins.outputs()) {
            let (logits, residuals) = own.split_at(self.bins.count);
            let cells: Vec<(f64, f64)> = log_softmax(logits)
                .into_iter()
                .zip(residuals)
                .enumerate()
                .map(|(k, (log, r))| (log, self.bins.decode(k, f64::from(*r))))
                .collect();
            let longer = |(sum, unit): &(f64, Vec<f64>)| -> Vec<(f64, Vec<f64>)> {
                cells.iter().map(|(log, u)| (sum + log, [&unit[..], &[*u]].concat())).collect()
            };
            best = best.iter().flat_map(longer).collect();
            best.sort_by(|a, b| b.0.total_cmp(&a.0));
            best.truncate(most);
        }
        let inside = |(_, unit): (f64, Vec<f64>)| {
            let mut theta = space.at(&unit);
            space.clamp(&mut theta);
            theta
        };
        best.into_iter().map(inside).collect()
    }
}
