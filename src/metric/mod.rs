//! Numbers that compare an achieved shape with a goal, and the costs that pull a rollout toward one.
use glam::DVec3;
use serde::{Deserialize, Serialize};

mod alignment;
mod assignment;
mod chamfer;
mod column;
mod cost;
mod coverage;
mod emd;
mod gibbs;
mod iou;
mod missed;
mod morton;
mod nearest;
mod registration;
mod rigid;
mod rmse;
mod sinkhorn;
mod softmin;
mod transport;
mod weighted;

pub use alignment::{Aligned, AlignedMetric, AlignedMetricSpec, AlignedSpec};
pub use chamfer::{Chamfer, ChamferSpec};
pub use column::{Column, MetricSpec};
pub use cost::{CostSpec, GoalCost, ShapeLoss};
pub use coverage::{Coverage, CoverageSpec, Inside, InsideSpec};
pub use emd::{EMD_LIMIT, Emd, EmdSpec};
pub use iou::{Iou, IouSpec};
pub use missed::{Missed, MissedSpec};
pub use rigid::{Freedom, Rigid};
pub use rmse::{MatchedRmse, MatchedRmseSpec};
pub use sinkhorn::{Entropic, Sinkhorn, SinkhornSpec};
pub use weighted::{Weighted, WeightedSpec};

/// A scalar on two point clouds \[m\], or on two matched particle lists.
pub trait Metric: Send + Sync {
    /// Column title.
    fn name(&self) -> &'static str;
    /// Unit, for the table: `m`, or nothing for a share in \[0, 1\].
    fn unit(&self) -> &'static str;
    /// Which of two numbers is better; the lower, unless the metric says otherwise.
    fn better(&self) -> Better {
        Better::Lower
    }
    /// The number; the worst there is (`∞` of a distance, 0 of a share) when a coordinate is not finite, `None` where the metric is
    /// not defined for these clouds (one is empty, or no correspondence).
    fn evaluate(&self, achieved: &[DVec3], goal: &[DVec3], matched: Matching) -> Option<f64>;
}

/// The direction in which a metric improves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Better {
    /// Distances: 0 is perfect.
    Lower,
    /// Shares: 1 is perfect.
    Higher,
}

/// Whether row i of one cloud is the same particle as row i of the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Matching {
    /// Rows correspond.
    Matched,
    /// Two samplings of shapes.
    Unmatched,
}

/// Every metric that each comparison reports, in the order of the tables' columns; a config may add others, see [`MetricSpec`].
pub static METRICS: &[&dyn Metric] =
    &[&Chamfer, &Emd, &MatchedRmse, &Iou { voxel: None }, &Coverage { radius: None }, &Inside { radius: None }];

/// What `metric` says of two samplings of the same shape: about what a perfect model would score against a goal that is a
/// sampling itself.
///
/// `None` where the metric needs correspondence, which two samplings do not have.
pub fn sampling_floor(metric: &dyn Metric, first: &[DVec3], second: &[DVec3]) -> Option<f64> {
    metric.evaluate(first, second, Matching::Unmatched)
}

fn is_finite(points: &[DVec3]) -> bool {
    points.iter().all(|p| p.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::state::stream;
    use rand::Rng;

    pub(super) fn cloud(count: usize, purpose: u64) -> Vec<DVec3> {
        let mut rng = stream(1, &[purpose]);
        (0..count).map(|_| DVec3::from_array(rng.random())).collect()
    }

    #[test]
    fn every_metric_is_zero_on_itself_symmetric_and_moves_no_further_than_the_cloud() {
        let (a, b) = (cloud(60, 1), cloud(60, 2));
        let shift = DVec3::new(0.03, -0.04, 0.12);
        let moved: Vec<DVec3> = a.iter().map(|p| *p + shift).collect();
        for metric in METRICS.iter().filter(|m| m.better() == Better::Lower) {
            let on = |x: &[DVec3], y: &[DVec3]| metric.evaluate(x, y, Matching::Matched).unwrap();
            assert_eq!(on(&a, &a), 0.0, "{}", metric.name());
            assert!((on(&a, &b) - on(&b, &a)).abs() < 1e-14, "{}", metric.name());
            // Chamfer is the sum of two directions, each of which a translation moves by at most its length.
            let directions = if metric.name() == Chamfer.name() { 2.0 } else { 1.0 };
            let distance = on(&a, &moved);
            assert!(distance > 0.0 && distance <= directions * shift.length() + 1e-12, "{}", metric.name());
        }
        let emd = Emd.evaluate(&a, &moved, Matching::Unmatched).unwrap();
        assert!((emd - shift.length()).abs() < 1e-12, "a translation is its own optimal transport: {emd}");
    }

    #[test]
    fn every_share_is_one_on_itself_and_nothing_far_away() {
        let a = cloud(60, 1);
        let away: Vec<DVec3> = a.iter().map(|p| *p + DVec3::X * 9.0).collect();
        for metric in METRICS.iter().filter(|m| m.better() == Better::Higher) {
            assert_eq!(
                (metric.unit(), metric.evaluate(&a, &a, Matching::Unmatched)),
                ("", Some(1.0)),
                "{}",
                metric.name()
            );
            assert_eq!(metric.evaluate(&away, &a, Matching::Unmatched), Some(0.0), "{}", metric.name());
        }
    }

    #[test]
    fn half_of_chamfer_is_at_most_emd_which_is_at_most_the_matched_error() {
        for purpose in 0..20 {
            let (a, b) = (cloud(40, purpose), cloud(40, 100 + purpose));
            let value = |metric: &dyn Metric| metric.evaluate(&a, &b, Matching::Matched).unwrap();
            assert!(value(&Chamfer) / 2.0 <= value(&Emd) + 1e-12);
            assert!(value(&Emd) <= value(&MatchedRmse) + 1e-12);
        }
    }

    #[test]
    fn clouds_that_are_not_finite_are_infinitely_far_and_empty_ones_have_no_distance() {
        let good = cloud(9, 3);
        for (bad, axis) in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY].into_iter().zip(0..) {
            let mut broken = good.clone();
            broken[4][axis] = bad;
            for metric in METRICS {
                let worst = if metric.better() == Better::Lower { f64::INFINITY } else { 0.0 };
                assert_eq!(metric.evaluate(&broken, &good, Matching::Matched), Some(worst), "{}", metric.name());
                assert_eq!(metric.evaluate(&good, &broken, Matching::Matched), Some(worst), "{}", metric.name());
            }
        }
        for metric in METRICS {
            assert_eq!(metric.evaluate(&[], &good, Matching::Unmatched), None);
            assert_eq!(metric.evaluate(&good, &[], Matching::Unmatched), None);
        }
    }

    #[test]
    fn the_sampling_floor_falls_as_samples_grow_and_needs_no_correspondence() {
        let floor = |metric: &dyn Metric, n| sampling_floor(metric, &cloud(n, 5), &cloud(n, 6));
        for metric in [&Chamfer as &dyn Metric, &Emd] {
            assert!(floor(metric, 400).unwrap() < floor(metric, 50).unwrap(), "{}", metric.name());
            assert!(floor(metric, 400).unwrap() > 0.0);
        }
        assert_eq!(floor(&MatchedRmse, 50), None);
    }
}
