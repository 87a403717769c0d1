//! How much of a goal region is covered, and how much of the material is inside.
use super::nearest::nearest;
use super::{Better, Matching, Metric, is_finite};
use crate::shape::spacing;
use anyhow::ensure;
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Share of the goal's points that have an achieved point within r: `(1/M) Σⱼ [minᵢ |aᵢ − bⱼ| ≤ r]`, the recall of Knapitsch, Park,
/// Zhou & Koltun (2017).
///
/// r is `REACH` of the goal's spacing (see [`spacing`]) unless it is given: two even samplings of one shape cover each other. A
/// share has no gradient but zero; a planner that should cover a region minimises [`super::Chamfer`], half of which is the mean of
/// the very distances counted here.
#[derive(Clone, Copy, Debug, Default)]
pub struct Coverage {
    /// r \[m\].
    pub radius: Option<f64>,
}

/// Share of the achieved points that are inside the goal region, seen from above: `(1/N) Σᵢ [minⱼ |P(aᵢ − bⱼ)| ≤ r]` with
/// `P(x, y, z) = (x, y, 0)`.
///
/// For piles pushed into a region of the table, whose points the goal is. r as for [`Coverage`], so that points up to r beside the
/// region still count. [`super::Chamfer`] serves as a loss here too: its other half is the mean of these distances.
#[derive(Clone, Copy, Debug, Default)]
pub struct Inside {
    /// r \[m\].
    pub radius: Option<f64>,
}

/// Config of [`Coverage`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CoverageSpec {
    /// Distance within which a point is covered \[m\]; by default in proportion to the goal's spacing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-6))]
    pub radius: Option<f64>,
}

/// Config of [`Inside`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct InsideSpec {
    /// Distance beside a point of the region that still counts as inside \[m\]; by default in proportion to the goal's spacing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-6))]
    pub radius: Option<f64>,
}

impl CoverageSpec {
    pub(crate) fn build(self) -> anyhow::Result<Coverage> {
        Ok(Coverage { radius: possible("coverage", self.radius)? })
    }
}

impl InsideSpec {
    pub(crate) fn build(self) -> anyhow::Result<Inside> {
        Ok(Inside { radius: possible("inside", self.radius)? })
    }
}

fn possible(metric: &str, radius: Option<f64>) -> anyhow::Result<Option<f64>> {
    let above = radius.is_none_or(|r| r > 0.0 && r.is_finite());
    ensure!(above, "`radius` of the metric {metric} must be a length above 0, got {radius:?}");
    Ok(radius)
}

/// The radius within which a point covers, in spacings.
const REACH: f64 = 1.5;

/// Share of `of` with one of `near` within `radius`, by default `REACH` of the goal's spacing.
fn share(of: &[DVec3], near: &[DVec3], goal: &[DVec3], radius: Option<f64>) -> Option<f64> {
    if of.is_empty() || near.is_empty() {
        return None;
    }
    if !is_finite(of) || !is_finite(near) {
        return Some(0.0);
    }
    let radius = radius.or_else(|| Some(REACH * spacing(goal)?))?;
    let within = nearest(of, near).iter().filter(|n| n.distance <= radius).count();
    Some(within as f64 / of.len() as f64)
}

impl Metric for Coverage {
    fn name(&self) -> &'static str {
        "coverage"
    }
    fn unit(&self) -> &'static str {
        ""
    }
    fn better(&self) -> Better {
        Better::Higher
    }
    fn evaluate(&self, achieved: &[DVec3], goal: &[DVec3], _: Matching) -> Option<f64> {
        share(goal, achieved, goal, self.radius)
    }
}

impl Metric for Inside {
    fn name(&self) -> &'static str {
        "inside"
    }
    fn unit(&self) -> &'static str {
        ""
    }
    fn better(&self) -> Better {
        Better::Higher
    }
    fn evaluate(&self, achieved: &[DVec3], goal: &[DVec3], _: Matching) -> Option<f64> {
        let flat = |points: &[DVec3]| points.iter().map(|p| p.with_z(0.0 * p.z)).collect::<Vec<_>>();
        share(&flat(achieved), &flat(goal), goal, self.radius)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::{CuboidSpec, ShapeSpec};
    use crate::state::stream;

    /// 21 × 21 points of a square of 1 m.
    fn square(by: DVec3) -> Vec<DVec3> {
        (0..21 * 21).map(|k| DVec3::new(f64::from(k / 21), f64::from(k % 21), 0.0) / 20.0 + by).collect()
    }

    #[test]
    fn a_square_moved_by_half_covers_half_and_lies_half_inside() {
        let goal = square(DVec3::ZERO);
        // The radius reaches one column further than the overlap of 11 columns of 21.
        let (radius, expected) = (Some(0.05 + 1e-9), 12.0 / 21.0);
        for lifted in [0.0, 0.3] {
            let moved = square(DVec3::new(0.5, 0.0, lifted));
            let covered = Coverage { radius }.evaluate(&moved, &goal, Matching::Unmatched);
            assert_eq!(covered, Some(if lifted > 0.0 { 0.0 } else { expected }));
            assert_eq!(Inside { radius }.evaluate(&moved, &goal, Matching::Unmatched), Some(expected));
        }
    }

    #[test]
    fn a_heap_in_a_corner_is_inside_but_does_not_cover() {
        let goal = square(DVec3::ZERO);
        let heap: Vec<DVec3> = goal.iter().map(|p| *p * DVec3::new(0.2, 0.2, 1.0) + DVec3::Z * 0.01).collect();
        let on = |metric: &dyn Metric, a: &[DVec3]| metric.evaluate(a, &goal, Matching::Unmatched).unwrap();
        assert_eq!(on(&Inside::default(), &heap), 1.0);
        assert!((on(&Coverage::default(), &heap) - 0.06).abs() < 0.03, "{}", on(&Coverage::default(), &heap));
    }

    #[test]
    fn two_samplings_of_one_shape_cover_each_other() {
        let spec = CuboidSpec { width: 0.06, length: 0.06, thickness: Some(0.03), volume: None };
        let shape = ShapeSpec::Cuboid(spec).build().unwrap();
        let sample = |k| shape.points(300, &mut stream(1, &[k]));
        let covered = Coverage::default().evaluate(&sample(1), &sample(2), Matching::Unmatched).unwrap();
        assert!(covered > 0.99, "{covered}");
    }
}
