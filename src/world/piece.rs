//! A piece beside the scene's own material.
use super::material::{Filling, Material, MaterialSpec};
use super::start::{StartSpec, between};
use anyhow::ensure;
use glam::DVec2;
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// More material in a scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PieceSpec {
    /// What it is made of, a file in `configs/material`.
    pub material: MaterialSpec,
    /// Its shape and size, drawn by seed.
    pub start: StartSpec,
    /// Ranges of where its middle stands along x and y \[m\].
    pub at: [[f64; 2]; 2],
    /// Range of the height at which its lowest point begins, above that of its start \[m\].
    pub raised: [f64; 2],
}

impl PieceSpec {
    /// Its material, once its numbers are checked.
    ///
    /// # Errors
    /// A sentence naming the key whose value is impossible.
    pub(super) fn check(&self) -> anyhow::Result<Box<dyn Material>> {
        for (key, [low, high]) in [("at", self.at[0]), ("at", self.at[1]), ("raised", self.raised)] {
            ensure!(
                low <= high && (high - low).is_finite(),
                "{key} has the range [{low}, {high}]; it must be [low, high]"
            );
        }
        ensure!(self.raised[0] >= 0.0, "raised begins at {} m, below the table; it must be at least 0", self.raised[0]);
        self.material.clone().build()
    }

    /// Draws where it goes, and hands that to `fill`.
    ///
    /// # Errors
    /// When the start is impossible, or `fill` fails.
    pub(super) fn place<T>(
        &self,
        rng: &mut ChaCha8Rng,
        fill: impl FnOnce(&Filling<'_>, &mut ChaCha8Rng) -> anyhow::Result<T>,
    ) -> anyhow::Result<T> {
        let region = self.start.clone().build()?.draw(rng);
        let at = DVec2::from_array(self.at.map(|range| between(range, rng)));
        let raised = region.raised + between(self.raised, rng);
        let filling = Filling { bounds: region.bounds, contains: &*region.contains, turn: region.turn, at, raised };
        fill(&filling, rng)
    }
}
