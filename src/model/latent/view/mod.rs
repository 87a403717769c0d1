//! What a latent model sees of a scene and tells of it: a cloud of points, or a picture from above.
use super::Start;
use crate::model::net::{LatentNet, PictureSize};
use glam::DVec3;

mod cloud;
mod picture;

pub use cloud::CloudSpec;
pub use picture::TopSpec;

/// How the start becomes a code, and a code displacements of the start's particles.
pub trait View: Send + Sync {
    /// How large its pictures are, where it sees any.
    fn picture(&self) -> Option<PictureSize>;
    /// The code of the start.
    fn encoded(&self, net: &LatentNet, start: &Start) -> Vec<f32>;
    /// `∂J/∂positions` of the start from `∂J/∂code`; the weights' share is added to `weights`, unless that is empty.
    fn encoded_vjp(&self, net: &LatentNet, start: &Start, at: &[f32], weights: &mut [f32]) -> Vec<DVec3>;
    /// What a code means for each particle of the start, (N, 3).
    fn decoded(&self, net: &LatentNet, start: &Start, code: &[f32]) -> Vec<f32>;
    /// `∂J/∂(code, positions of the start)` from `∂J/∂decoded`; the weights' share likewise.
    fn decoded_vjp(
        &self,
        net: &LatentNet,
        start: &Start,
        code: &[f32],
        at: &[f32],
        weights: &mut [f32],
    ) -> (Vec<f32>, Vec<DVec3>);
}

family! {
    /// The kinds of views.
    ViewSpec builds Box<dyn View> { Cloud(CloudSpec), Picture(TopSpec) }
}

impl Default for ViewSpec {
    fn default() -> Self {
        Self::Cloud(CloudSpec {})
    }
}

impl ViewSpec {
    /// Whether a config may leave the key out.
    pub(super) fn is_default(&self) -> bool {
        *self == Self::default()
    }
}
