//! What a picture shows.
use super::{GridSpec, NUMBERS};
use anyhow::ensure;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How the scene becomes a picture, and the picture's field motion.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PictureSpec {
    /// Where it lies and how fine it is.
    pub grid: GridSpec,
    /// Distance around a particle over which it is as high as it is, fading at the end \[m\].
    #[schemars(range(min = 1e-6))]
    pub top: f64,
    /// Distance from a tool beyond which it is not seen \[m\].
    #[schemars(range(min = 1e-6))]
    pub reach: f64,
    /// Displacement in a control step that counts as one, for the tool's and for the output \[m\].
    #[schemars(range(min = 1e-9))]
    pub scale: f64,
}

impl PictureSpec {
    pub(crate) fn check(&self) -> anyhow::Result<()> {
        self.grid.check()?;
        for (key, value) in [("top", self.top), ("reach", self.reach), ("scale", self.scale)] {
            ensure!(value > 0.0 && value.is_finite(), "picture.{key} must be a positive length, got {value}");
        }
        Ok(())
    }

    /// Numbers a cell that the network reads.
    pub(crate) fn inputs(&self) -> usize {
        1 + NUMBERS * self.grid.levels
    }

    /// Numbers a cell that the network writes.
    pub(crate) fn outputs(&self) -> usize {
        3 * self.grid.levels
    }
}
