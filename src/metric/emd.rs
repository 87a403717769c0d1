//! Earth mover's distance.
use super::assignment::assign;
use super::{Matching, Metric, ShapeLoss, Sinkhorn, SinkhornSpec, is_finite};
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The most points that are assigned to each other exactly; larger clouds go through [`Sinkhorn`].
pub const EMD_LIMIT: usize = 512;

/// ε of [`Sinkhorn`] over the spacing of the points, for which the goal's size over ∛N stands.
const EPSILON: f64 = 0.05;

/// `min over plans π of Σ πᵢⱼ |aᵢ − bⱼ|` \[m\] (Rubner, Tomasi & Guibas 2000) with equal weights: by exact assignment where both
/// clouds have the same number of points up to [`EMD_LIMIT`], else as the Sinkhorn divergence of a small ε on all points.
///
/// Measured in the unit cube between two samplings of it, one of them shifted or squashed or neither, the divergence lies 0.3 – 1.3 %
/// below the exact distance for 300 to 2000 points in both clouds, and 0.9 – 2.1 % for unequal ones (100 and 900 to 512 and 4096);
/// thinning the clouds to equal sizes up to the limit would add up to 14 % at 1000 points and 38 % at 2000.
#[derive(Clone, Copy, Debug)]
pub struct Emd;

/// Config of [`Emd`] as a cost.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EmdSpec {}

impl EmdSpec {
    pub(crate) fn build(self) -> anyhow::Result<Emd> {
        Ok(Emd)
    }
}

impl Emd {
    /// What stands for the exact distance between so many points.
    pub fn approximation(points: usize, goal: usize) -> Sinkhorn {
        let epsilon = EPSILON / (points.max(goal).max(1) as f64).cbrt();
        Sinkhorn::of(&SinkhornSpec { epsilon, tolerance: 1e-4, iterations: 500 })
    }

    fn is_exact(points: &[DVec3], goal: &[DVec3]) -> bool {
        points.len() == goal.len() && points.len() <= EMD_LIMIT
    }
}

impl Metric for Emd {
    fn name(&self) -> &'static str {
        "emd"
    }
    fn unit(&self) -> &'static str {
        "m"
    }
    fn evaluate(&self, achieved: &[DVec3], goal: &[DVec3], _: Matching) -> Option<f64> {
        (!achieved.is_empty() && !goal.is_empty()).then(|| self.value(achieved, goal))
    }
}

impl ShapeLoss for Emd {
    fn value(&self, points: &[DVec3], goal: &[DVec3]) -> f64 {
        match Self::is_exact(points, goal) {
            true if !is_finite(points) || !is_finite(goal) => f64::INFINITY,
            true => assign(points, goal).map_or(f64::INFINITY, |a| a.mean),
            false => Self::approximation(points.len(), goal.len()).value(points, goal),
        }
    }

    fn gradient(&self, points: &[DVec3], goal: &[DVec3]) -> Vec<DVec3> {
        if !Self::is_exact(points, goal) {
            return Self::approximation(points.len(), goal.len()).gradient(points, goal);
        }
        let mut out = vec![DVec3::ZERO; points.len()];
        if let Some(assignment) = assign(points, goal) {
            for &(i, j) in &assignment.pairs {
                out[i] = (points[i] - goal[j]).normalize_or_zero() / assignment.pairs.len() as f64;
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metric::tests::cloud;

    fn least(a: &[DVec3], b: &[DVec3], used: &mut Vec<usize>) -> f64 {
        let Some((first, rest)) = a.split_first() else { return 0.0 };
        let mut best = f64::INFINITY;
        for j in 0..b.len() {
            if !used.contains(&j) {
                used.push(j);
                best = best.min(first.distance(b[j]) + least(rest, b, used));
                used.pop();
            }
        }
        best
    }

    #[test]
    fn it_is_the_least_over_all_permutations() {
        for n in 1..=6 {
            for purpose in 0..10 {
                let (a, b) = (cloud(n, purpose), cloud(n, 50 + purpose));
                let expected = least(&a, &b, &mut Vec::new()) / n as f64;
                let found = Emd.evaluate(&a, &b, Matching::Unmatched).unwrap();
                assert!((found - expected).abs() < 1e-14, "n = {n}: {found} against {expected}");
            }
        }
    }

    #[test]
    fn a_larger_sampling_of_the_same_shape_is_nearer_than_another_shape() {
        let (few, many) = (cloud(100, 1), cloud(900, 2));
        let floor = Emd.evaluate(&few, &cloud(100, 3), Matching::Unmatched).unwrap();
        let uneven = Emd.evaluate(&few, &many, Matching::Unmatched).unwrap();
        assert!(uneven < 1.2 * floor, "{uneven} against a floor of {floor}");
        let shifted: Vec<DVec3> = many.iter().map(|p| *p + DVec3::X).collect();
        let moved = Emd.evaluate(&few, &shifted, Matching::Unmatched).unwrap();
        assert!((moved - 1.0).abs() < floor, "{moved}");
    }
}
