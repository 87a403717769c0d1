//! A linear model of the picture from above.
use super::height_map::{HeightMapModel, PictureSpec};
use super::net::{Filter, FilterArchitecture, Trainable};
use anyhow::ensure;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Config of the model whose field of displacements is a linear filter of the picture: for a given motion of the tool the same linear
/// transport of whatever lies on the table (after Suh & Tedrake 2020, who fit one matrix an action).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LinearSpec {
    /// What the picture shows.
    pub picture: PictureSpec,
    /// Cells along a side of the filter, odd.
    #[schemars(range(min = 1, max = 63))]
    pub width: usize,
    /// File of trained weights (safetensors).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub weights: Option<PathBuf>,
}

impl LinearSpec {
    pub(super) fn build(self) -> anyhow::Result<HeightMapModel<Filter>> {
        self.picture.check()?;
        let odd = self.width % 2 == 1 && self.width < 64;
        ensure!(odd, "width must be an odd number of cells up to 63, got {}", self.width);
        let (size, inputs, outputs) = (self.picture.grid.size(), self.picture.inputs(), self.picture.outputs());
        let network = Filter::new(FilterArchitecture { size, inputs, outputs, width: self.width });
        Ok(HeightMapModel::new(self.picture, network.loaded(self.weights.as_deref())?))
    }
}
