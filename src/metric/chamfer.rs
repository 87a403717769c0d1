//! Chamfer distance.
use super::nearest::nearest;
use super::{Matching, Metric, ShapeLoss, is_finite};
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `(1/N) Σᵢ minⱼ |aᵢ − bⱼ| + (1/M) Σⱼ minᵢ |aᵢ − bⱼ|` \[m\], of plain distances, not squared ones
/// (as Shi, Xu, Clarke, Li & Wu 2023, RoboCook).
#[derive(Clone, Copy, Debug)]
pub struct Chamfer;

/// Config of [`Chamfer`] as a cost.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ChamferSpec {}

impl ChamferSpec {
    pub(crate) fn build(self) -> anyhow::Result<Chamfer> {
        Ok(Chamfer)
    }
}

impl Metric for Chamfer {
    fn name(&self) -> &'static str {
        "chamfer"
    }
    fn unit(&self) -> &'static str {
        "m"
    }
    fn evaluate(&self, achieved: &[DVec3], goal: &[DVec3], _: Matching) -> Option<f64> {
        (!achieved.is_empty() && !goal.is_empty()).then(|| self.value(achieved, goal))
    }
}

impl ShapeLoss for Chamfer {
    fn value(&self, points: &[DVec3], goal: &[DVec3]) -> f64 {
        if points.is_empty() || goal.is_empty() || !is_finite(points) || !is_finite(goal) {
            return f64::INFINITY;
        }
        let mean = |from: &[DVec3], to: &[DVec3]| {
            nearest(from, to).iter().map(|n| n.distance).sum::<f64>() / from.len() as f64
        };
        mean(points, goal) + mean(goal, points)
    }

    fn gradient(&self, points: &[DVec3], goal: &[DVec3]) -> Vec<DVec3> {
        let mut out = vec![DVec3::ZERO; points.len()];
        if points.is_empty() || goal.is_empty() {
            return out;
        }
        for (i, near) in nearest(points, goal).iter().enumerate() {
            out[i] += (points[i] - goal[near.row]).normalize_or_zero() / points.len() as f64;
        }
        for (j, near) in nearest(goal, points).iter().enumerate() {
            out[near.row] += (points[near.row] - goal[j]).normalize_or_zero() / goal.len() as f64;
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_clouds_by_hand() {
        let (a, b) = ([DVec3::ZERO, DVec3::X * 2.0], [DVec3::Y, DVec3::X * 3.0, DVec3::X * 5.0]);
        // a → b: 1 and 1; b → a: 1, 1 and 3.
        let expected = 1.0 + 5.0 / 3.0;
        assert!((Chamfer.evaluate(&a, &b, Matching::Unmatched).unwrap() - expected).abs() < 1e-15);
        assert_eq!(Chamfer.evaluate(&[DVec3::ZERO], &[DVec3::Z * 0.5], Matching::Unmatched), Some(1.0));
    }
}
