//! Held out by size: the episodes that start with the most material.
use super::{Entry, Episode, HoldOut, share};
use glam::{DMat3, DVec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The ⌈fraction · n⌉ of all n episodes whose starts are largest are held out, at most n − 1: every held-out scene is larger than
/// every one to learn from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SizeSpec {}

impl SizeSpec {
    /// Nothing to check.
    ///
    /// # Errors
    /// Never.
    pub fn build(self) -> anyhow::Result<impl HoldOut> {
        Ok(self)
    }
}

impl HoldOut for SizeSpec {
    fn held_out(&self, episodes: &[Episode], _: &[Entry], fraction: f64) -> Vec<bool> {
        let sizes: Vec<f64> = episodes.iter().map(|e| size(&e.states[0].positions)).collect();
        let mut order: Vec<usize> = (0..sizes.len()).collect();
        order.sort_by(|a, b| sizes[*b].total_cmp(&sizes[*a]));
        let mut held = vec![false; sizes.len()];
        order[..share(fraction, sizes.len())].iter().for_each(|k| held[*k] = true);
        held
    }
}

/// Volume of the box with the same second moments, `12^{3/2} √det Σ` \[m³\].
///
/// Turning a piece or pressing it flat at constant volume leaves it as it was, up to what is not affine.
fn size(points: &[DVec3]) -> f64 {
    let n = points.len().max(1) as f64;
    let mean = points.iter().sum::<DVec3>() / n;
    let outer = |d: DVec3| DMat3::from_cols(d * d.x, d * d.y, d * d.z);
    let covariance = points.iter().fold(DMat3::ZERO, |sum, p| sum + outer(p - mean)) * (1.0 / n);
    12f64.powf(1.5) * covariance.determinant().max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::super::super::made_up;
    use super::*;
    use crate::state::Particles;

    /// A block of `sides` \[m\], sampled at the middles of 20 × 20 × 20 cells.
    fn block(sides: DVec3) -> Vec<DVec3> {
        let middle = |i: usize| (i as f64 + 0.5) / 20.0 - 0.5;
        let cell = |i: usize| DVec3::new(middle(i % 20), middle(i / 20 % 20), middle(i / 400)) * sides;
        (0..8000).map(cell).collect()
    }

    #[test]
    fn a_block_is_as_large_as_it_is_however_it_is_turned_or_pressed() {
        let sides = DVec3::new(0.06, 0.05, 0.03);
        let close = |points: &[DVec3]| (size(points) / 9e-5 - 1.0).abs() < 0.01;
        assert!(close(&block(sides)), "{}", size(&block(sides)));
        let turned: Vec<DVec3> =
            block(sides).into_iter().map(|p| glam::DQuat::from_rotation_z(0.7) * p + DVec3::splat(0.3)).collect();
        assert!(close(&turned) && close(&block(sides * DVec3::new(2.0, 1.5, 1.0 / 3.0))));
    }

    #[test]
    fn every_scene_held_out_is_larger_than_every_one_to_learn_from() {
        let scale = [1.0, 1.4, 0.8, 1.2, 1.3, 0.9, 1.1];
        let episodes: Vec<Episode> = scale
            .iter()
            .map(|s| {
                let mut episode = made_up(2);
                episode.states[0] = Particles::at_rest(block(DVec3::splat(0.05 * s)));
                episode
            })
            .collect();
        let held = SizeSpec {}.held_out(&episodes, &[], 0.25);
        assert_eq!(held, scale.map(|s| s > 1.25));
        assert_eq!(SizeSpec {}.held_out(&episodes, &[], 1.0).iter().filter(|h| !**h).count(), 1);
    }
}
