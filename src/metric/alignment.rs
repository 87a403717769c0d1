//! Shapes compared wherever they lie and however they are turned.
use super::registration::register;
use super::rigid::{Freedom, kabsch};
use super::{Better, Chamfer, CostSpec, Matching, Metric, MetricSpec, ShapeLoss, is_finite};
use anyhow::ensure;
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Config of [`Aligned`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AlignedSpec {
    /// The loss after alignment.
    pub of: Box<CostSpec>,
    /// What may be moved.
    #[serde(default)]
    pub freedom: Freedom,
}

impl AlignedSpec {
    pub(crate) fn build(self) -> anyhow::Result<Aligned> {
        let of = self.of.build()?;
        ensure!(
            of.has_gradient(),
            "cost.of has no gradient, which the search for the best motion descends; give it a distance"
        );
        Ok(Aligned { of, freedom: self.freedom })
    }
}

/// `min over rigid motions T of loss(T a, b)` \[m\], the least that was found from many starts.
///
/// The gradient is `Rᵀ ∂loss/∂(T a)` with T held, by the envelope theorem exact where T is a minimiser. The search descends the loss
/// itself to the last digits of its value, which leaves about 1e-6 of the gradient.
pub struct Aligned {
    of: Box<dyn ShapeLoss>,
    freedom: Freedom,
}

impl ShapeLoss for Aligned {
    fn value(&self, points: &[DVec3], goal: &[DVec3]) -> f64 {
        let motion = register(points, goal, self.freedom, self.of.as_ref());
        motion.map_or(f64::INFINITY, |motion| self.of.value(&motion.apply(points), goal))
    }

    fn gradient(&self, points: &[DVec3], goal: &[DVec3]) -> Vec<DVec3> {
        let Some(motion) = register(points, goal, self.freedom, self.of.as_ref()) else {
            return vec![DVec3::ZERO; points.len()];
        };
        let back = motion.rotation.conjugate();
        self.of.gradient(&motion.apply(points), goal).into_iter().map(|g| back * g).collect()
    }
}

/// Config of [`AlignedMetric`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AlignedMetricSpec {
    /// The metric after alignment.
    pub of: Box<MetricSpec>,
    /// What may be moved.
    #[serde(default)]
    pub freedom: Freedom,
}

impl AlignedMetricSpec {
    pub(crate) fn build(self) -> anyhow::Result<AlignedMetric> {
        Ok(AlignedMetric { of: self.of.build()?, freedom: self.freedom })
    }
}

/// A metric after alignment: by `kabsch` where rows correspond, else to the least Chamfer distance.
pub struct AlignedMetric {
    /// The metric.
    pub of: Box<dyn Metric>,
    /// What may be moved.
    pub freedom: Freedom,
}

impl Metric for AlignedMetric {
    fn name(&self) -> &'static str {
        self.of.name()
    }
    fn unit(&self) -> &'static str {
        self.of.unit()
    }
    fn better(&self) -> Better {
        self.of.better()
    }
    fn evaluate(&self, achieved: &[DVec3], goal: &[DVec3], matched: Matching) -> Option<f64> {
        let finite = is_finite(achieved) && is_finite(goal);
        let motion = if finite && matched == Matching::Matched && achieved.len() == goal.len() {
            let pairs: Vec<_> = achieved.iter().copied().zip(goal.iter().copied()).collect();
            Some(kabsch(&pairs, self.freedom))
        } else {
            register(achieved, goal, self.freedom, &Chamfer)
        };
        match motion {
            Some(motion) => self.of.evaluate(&motion.apply(achieved), goal, matched),
            None => self.of.evaluate(achieved, goal, matched),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metric::rigid::Rigid;
    use crate::metric::tests::cloud;
    use crate::metric::{Emd, MatchedRmse};
    use glam::{DQuat, EulerRot};

    fn aligned(of: Box<dyn ShapeLoss>, freedom: Freedom) -> Aligned {
        Aligned { of, freedom }
    }

    #[test]
    fn a_cloud_turned_and_shifted_is_at_no_distance() {
        let a: Vec<DVec3> = cloud(80, 1).iter().map(|p| *p * DVec3::new(0.1, 0.07, 0.03)).collect();
        for k in 0..9 {
            let turn = 0.7 * f64::from(k);
            let (flat, whole) =
                (DQuat::from_rotation_z(turn), DQuat::from_euler(EulerRot::ZXY, turn, 2.0 * turn, -turn));
            let (sideways, anywhere) = (DVec3::new(0.2, -0.1, 0.0), DVec3::new(0.2, -0.1, 0.4));
            for (freedom, rotation, translation) in [(Freedom::Yaw, flat, sideways), (Freedom::Full, whole, anywhere)] {
                let moved = Rigid { rotation, translation }.apply(&a);
                for of in [Box::new(Chamfer) as Box<dyn ShapeLoss>, Box::new(Emd)] {
                    let (before, after) = (of.value(&moved, &a), aligned(of, freedom).value(&moved, &a));
                    assert!(after < 1e-9 && before > 0.01, "{freedom:?} {turn}: {before} became {after}");
                }
                let metric = AlignedMetric { of: Box::new(MatchedRmse), freedom };
                assert!(metric.evaluate(&moved, &a, Matching::Matched).unwrap() < 1e-12);
            }
        }
    }

    #[test]
    fn it_is_never_further_than_without_and_knows_what_it_may_not_move() {
        let a = cloud(60, 1);
        let raised: Vec<DVec3> = a.iter().map(|p| *p + DVec3::new(0.3, 0.0, 0.25)).collect();
        let value = |freedom| aligned(Box::new(Emd), freedom).value(&raised, &a);
        assert!((value(Freedom::Yaw) - 0.25).abs() < 1e-6, "{}", value(Freedom::Yaw));
        assert!(value(Freedom::Full) < 1e-9);
        for purpose in 0..5 {
            let b = cloud(60, 10 + purpose);
            assert!(aligned(Box::new(Chamfer), Freedom::Yaw).value(&a, &b) <= Chamfer.value(&a, &b));
        }
    }

    #[test]
    fn clouds_that_are_not_finite_are_infinitely_far() {
        let (a, broken) = (cloud(5, 1), vec![DVec3::NAN; 5]);
        let loss = aligned(Box::new(Chamfer), Freedom::Yaw);
        assert_eq!((loss.value(&broken, &a), loss.value(&[], &a)), (f64::INFINITY, f64::INFINITY));
        assert_eq!(loss.gradient(&broken, &a), vec![DVec3::ZERO; 5]);
        let metric = AlignedMetric { of: Box::new(MatchedRmse), freedom: Freedom::Full };
        assert_eq!(metric.evaluate(&broken, &a, Matching::Matched), Some(f64::INFINITY));
        assert_eq!(metric.evaluate(&[], &a, Matching::Matched), None);
    }
}
