//! A small convolutional model of the picture from above.
use super::height_map::{HeightMapModel, PictureSpec};
use super::net::{Trainable, UNet, UNetArchitecture};
use anyhow::ensure;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Config of the model whose field of displacements a U-Net reads from the picture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UNetSpec {
    /// What the picture shows.
    pub picture: PictureSpec,
    /// Channels at full resolution; twice as many at each coarser one.
    #[schemars(range(min = 1, max = 256))]
    pub width: usize,
    /// Number of times that the resolution is halved.
    #[schemars(range(max = 6))]
    pub depth: usize,
    /// Seed of the untrained weights.
    pub seed: u64,
    /// File of trained weights (safetensors).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub weights: Option<PathBuf>,
}

impl UNetSpec {
    pub(super) fn build(self) -> anyhow::Result<HeightMapModel<UNet>> {
        self.picture.check()?;
        let (width, depth, size) = (self.width, self.depth, self.picture.grid.size());
        ensure!((1..=256).contains(&width), "width must be between 1 and 256, got {width}");
        ensure!(depth <= 6, "depth must be at most 6, got {depth}");
        let block = 1 << depth;
        let even = size.rows % block == 0 && size.columns % block == 0;
        ensure!(even, "a picture of {} × {} cells cannot be halved {depth} times", size.rows, size.columns);
        let (inputs, outputs) = (self.picture.inputs(), self.picture.outputs());
        ensure!(
            width << depth <= 1024 && size.cells() * 9 * width.max(inputs) <= 1 << 28,
            "a U-Net of {width} channels halved {depth} times is too large for a picture of {} × {} cells; lower one of them",
            size.rows,
            size.columns
        );
        let network = UNet::new(UNetArchitecture { size, inputs, outputs, width, depth }, self.seed);
        Ok(HeightMapModel::new(self.picture, network.loaded(self.weights.as_deref())?))
    }
}
