//! Root mean square error of matched particles.
use super::{Matching, Metric, is_finite};
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `√((1/N) Σᵢ |aᵢ − bᵢ|²)` \[m\], row i of both lists being the same particle.
#[derive(Clone, Copy, Debug)]
pub struct MatchedRmse;

/// Config of [`MatchedRmse`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MatchedRmseSpec {}

impl MatchedRmseSpec {
    pub(crate) fn build(self) -> anyhow::Result<MatchedRmse> {
        Ok(MatchedRmse)
    }
}

impl Metric for MatchedRmse {
    fn name(&self) -> &'static str {
        "rmse"
    }
    fn unit(&self) -> &'static str {
        "m"
    }
    fn evaluate(&self, achieved: &[DVec3], goal: &[DVec3], matched: Matching) -> Option<f64> {
        if matched == Matching::Unmatched || achieved.len() != goal.len() || goal.is_empty() {
            return None;
        }
        if !is_finite(achieved) || !is_finite(goal) {
            return Some(f64::INFINITY);
        }
        let sum: f64 = achieved.iter().zip(goal).map(|(a, b)| a.distance_squared(*b)).sum();
        Some((sum / goal.len() as f64).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn by_hand_and_only_where_rows_correspond() {
        let (a, b) = ([DVec3::ZERO, DVec3::X], [DVec3::new(3.0, 4.0, 0.0), DVec3::X]);
        assert_eq!(MatchedRmse.evaluate(&a, &b, Matching::Matched), Some((25.0f64 / 2.0).sqrt()));
        assert_eq!(MatchedRmse.evaluate(&a, &b, Matching::Unmatched), None);
        assert_eq!(MatchedRmse.evaluate(&a, &b[..1], Matching::Matched), None);
    }
}
