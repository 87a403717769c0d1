//! When the world is observed and planned in, and what the tools are aimed at.
use crate::metric::{Chamfer, Matching, Metric};
use crate::state::Particles;
use crate::tool::Workpiece;
use crate::world::World;
use anyhow::ensure;
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Whether the world is observed between actions, and what for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ControlSpec {
    /// Observe, plan, execute, observe again.
    #[default]
    Closed,
    /// Observe once; later actions are planned from what the model predicts.
    Open,
    /// Observe after every action, and keep to the plan as long as it describes a next action and the world is where the model
    /// predicted it.
    Triggered {
        /// Chamfer distance between what is observed and what was predicted above which a new plan is made \[m\].
        #[schemars(range(min = 0.0))]
        threshold: f64,
    },
}

impl ControlSpec {
    /// Refuses a threshold that is no distance, and one that no plan of `lookahead` actions can be kept by.
    ///
    /// # Errors
    /// A sentence naming the key.
    pub(super) fn check(self, lookahead: usize) -> anyhow::Result<()> {
        let Self::Triggered { threshold } = self else { return Ok(()) };
        ensure!(
            lookahead > 1,
            "`control` is triggered, but plans describe one action, so that none is ever kept; set `lookahead=2`"
        );
        ensure!(threshold >= 0.0, "control.triggered.threshold is {threshold} m; it must be at least 0");
        Ok(())
    }

    /// Whether a plan made for `predicted` \[m\] still serves where `seen` is observed; what is no number never does.
    pub(super) fn keeps(self, predicted: &[DVec3], seen: &Particles) -> bool {
        let Self::Triggered { threshold } = self else { return false };
        let error = Chamfer.evaluate(&seen.positions, predicted, Matching::Unmatched);
        error.is_some_and(|error| error <= threshold)
    }
}

/// What of the scene the tools are aimed at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum AimSpec {
    /// All of it.
    #[default]
    Whole,
    /// One piece after the other, in the order of the scene, and again the first.
    Pieces,
}

impl AimSpec {
    /// Whether it is what is done unless said otherwise.
    pub(super) fn is_default(&self) -> bool {
        *self == Self::default()
    }

    /// What the action of this number is aimed at, of the particles `seen` in `world`.
    pub(super) fn at(self, action: u64, seen: &Particles, world: &World) -> Workpiece {
        if self == Self::Whole {
            return Workpiece::around(seen);
        }
        let pieces = world.pieces();
        let count = 1 + pieces.iter().copied().max().unwrap_or_default();
        let own = seen.positions.iter().zip(&pieces).filter(|(_, piece)| **piece == action as usize % count);
        Workpiece::around(&Particles::at_rest(own.map(|(position, _)| *position).collect()))
    }
}
