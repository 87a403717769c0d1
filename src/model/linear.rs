//! A linear model of the picture from above.
use super::height_map::{HeightMapModel, PictureSpec};
use super::net::{Filter, FilterArchitecture, Trainable};
use anyhow::ensure;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Most numbers that the cells' neighbourhoods may hold together, for a step's memory of a gigabyte.
const LARGEST: usize = 1 << 28;

/// Config of the model whose field of displacements is linear in the picture, `field_c = Σ_o W_o picture_{c+o}` over the cells o around c.
///
/// Suh & Tedrake (2020) let the next image be linear in the image, one matrix an action; here it is the displacement that is linear, in
/// the heights and the tool's motion together, so that one set of weights serves every action.
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
        ensure!(
            size.cells() * self.width * self.width * inputs <= LARGEST,
            "a filter {} cells wide is too large for a picture of {} × {} cells of {inputs} numbers; lower one of them",
            self.width,
            size.rows,
            size.columns
        );
        let network = Filter::new(FilterArchitecture { size, inputs, outputs, width: self.width });
        Ok(HeightMapModel::new(self.picture, network.loaded(self.weights.as_deref())?))
    }
}
