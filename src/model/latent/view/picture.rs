//! A height map from above, and a field over it: from pixels to pixels.
use super::View;
use crate::model::height_map::{GridSpec, Top};
use crate::model::latent::{Start, rows};
use crate::model::net::{DecodePicture, EncodePicture, LatentNet, PictureSize, forward, pull};
use anyhow::ensure;
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The code is what a network says of the height map as a camera above sees it, and means a field of displacements at every cell and
/// level, in which the start's particles ride. What the camera does not see, no code knows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TopSpec {
    /// Where the picture lies and how fine it is.
    pub grid: GridSpec,
    /// Distance around a particle over which it is as high as it is, fading at the end \[m\].
    #[schemars(range(min = 1e-6))]
    pub top: f64,
}

impl TopSpec {
    pub(crate) fn build(self) -> anyhow::Result<impl View> {
        self.grid.check()?;
        ensure!(self.top > 0.0 && self.top.is_finite(), "view.top must be a positive length, got {}", self.top);
        Ok(self)
    }

    fn seen(&self, start: &Start) -> (Top, Vec<f32>) {
        let top = Top::of(&self.grid, self.top, &start.positions);
        let heights = top.heights.iter().map(|height| (height / self.grid.height) as f32).collect();
        (top, heights)
    }
}

impl View for TopSpec {
    fn picture(&self) -> Option<PictureSize> {
        let seen = self.grid.size().cells();
        Some(PictureSize { seen, told: 3 * seen * self.grid.levels })
    }

    fn encoded(&self, net: &LatentNet, start: &Start) -> Vec<f32> {
        let heights = self.seen(start).1;
        let cells = heights.len();
        forward(&EncodePicture { net }, vec![(heights, cells)])
    }

    fn encoded_vjp(&self, net: &LatentNet, start: &Start, at: &[f32], weights: &mut [f32]) -> Vec<DVec3> {
        let (top, heights) = self.seen(start);
        let cells = heights.len();
        let (_, pulled) = pull(&EncodePicture { net }, vec![(heights, cells)], at, weights);
        let at_top: Vec<f64> = pulled[0].iter().map(|g| f64::from(*g) / self.grid.height).collect();
        let mut by_positions = vec![DVec3::ZERO; start.positions.len()];
        top.pull(&self.grid, &start.positions, &at_top, &mut by_positions);
        by_positions
    }

    fn decoded(&self, net: &LatentNet, start: &Start, code: &[f32]) -> Vec<f32> {
        let field = forward(&DecodePicture { net }, vec![(code.to_vec(), code.len())]);
        let at = |x: &DVec3| self.grid.read(&field, *x).as_vec3().to_array();
        start.positions.iter().flat_map(at).collect()
    }

    fn decoded_vjp(
        &self,
        net: &LatentNet,
        start: &Start,
        code: &[f32],
        at: &[f32],
        weights: &mut [f32],
    ) -> (Vec<f32>, Vec<DVec3>) {
        let mut at_field = vec![0.0; 3 * self.grid.size().cells() * self.grid.levels];
        for (x, at) in start.positions.iter().zip(rows(at)) {
            self.grid.spread(&mut at_field, *x, at);
        }
        let inputs = vec![(code.to_vec(), code.len())];
        let (field, mut pulled) = pull(&DecodePicture { net }, inputs, &at_field, weights);
        let slopes = start.positions.iter().zip(rows(at)).map(|(x, at)| self.grid.slope(&field, *x, at));
        (pulled.swap_remove(0), slopes.collect())
    }
}
