//! Particles around their middle, each by itself.
use super::View;
use crate::model::latent::{Start, rows};
use crate::model::net::{Decode, Encode, LatentNet, Mixing, PictureSize, forward, pull};
use glam::{DVec2, DVec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// The code is the mean of what a network says of every particle, and the start's particles are folded into what it means.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CloudSpec {}

impl CloudSpec {
    pub(crate) fn build(self) -> anyhow::Result<impl View> {
        Ok(self)
    }
}

impl CloudSpec {
    /// `∂J/∂positions` from `∂J/∂points`, the middle moving with them.
    fn by_positions(start: &Start, at_points: &[f32]) -> Vec<DVec3> {
        let at: Vec<DVec3> = rows(at_points).map(|g| g / start.extent).collect();
        let share = at.iter().map(|g| g.truncate()).sum::<DVec2>() / at.len().max(1) as f64;
        at.into_iter().map(|g| g - share.extend(0.0)).collect()
    }
}

impl View for CloudSpec {
    fn picture(&self) -> Option<PictureSize> {
        None
    }

    fn encoded(&self, net: &LatentNet, start: &Start) -> Vec<f32> {
        let mean = Arc::new(Mixing::mean(start.positions.len()));
        forward(&Encode { net, mean }, vec![(start.points.clone(), 3)])
    }

    fn encoded_vjp(&self, net: &LatentNet, start: &Start, at: &[f32], weights: &mut [f32]) -> Vec<DVec3> {
        let mean = Arc::new(Mixing::mean(start.positions.len()));
        let (_, pulled) = pull(&Encode { net, mean }, vec![(start.points.clone(), 3)], at, weights);
        Self::by_positions(start, &pulled[0])
    }

    fn decoded(&self, net: &LatentNet, start: &Start, code: &[f32]) -> Vec<f32> {
        let copies = Arc::clone(&start.copies);
        forward(&Decode { net, copies }, vec![(code.to_vec(), code.len()), (start.points.clone(), 3)])
    }

    fn decoded_vjp(
        &self,
        net: &LatentNet,
        start: &Start,
        code: &[f32],
        at: &[f32],
        weights: &mut [f32],
    ) -> (Vec<f32>, Vec<DVec3>) {
        let copies = Arc::clone(&start.copies);
        let inputs = vec![(code.to_vec(), code.len()), (start.points.clone(), 3)];
        let (_, mut pulled) = pull(&Decode { net, copies }, inputs, at, weights);
        let by_positions = Self::by_positions(start, &pulled[1]);
        (pulled.swap_remove(0), by_positions)
    }
}
