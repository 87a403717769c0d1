//! A share as a cost: what a goal still lacks of one.
use super::{Better, Matching, Metric, MetricSpec, ShapeLoss, is_finite};
use anyhow::ensure;
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Config of [`Missed`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MissedSpec {
    /// The share: `iou`, `coverage` or `inside`.
    pub of: Box<MetricSpec>,
    /// What missing all of it costs \[m\]; with the default a millimetre is one hundredth of the share.
    #[serde(default = "hundredths")]
    #[schemars(range(min = 1e-6))]
    pub length: f64,
}

fn hundredths() -> f64 {
    0.1
}

impl MissedSpec {
    pub(crate) fn build(self) -> anyhow::Result<Missed> {
        let of = self.of.build()?;
        ensure!(
            of.better() == Better::Higher,
            "cost.of is {}, a distance and no share; name it as the cost itself: cost.kind = \"chamfer\", \"emd\" or \"sinkhorn\"",
            of.name()
        );
        ensure!(
            self.length > 0.0 && self.length.is_finite(),
            "cost.length must be a length above 0, got {}",
            self.length
        );
        Ok(Missed { of, length: self.length })
    }
}

/// `λ (1 − share(a, b))` \[m\] with λ the `length`, for planners that sample: a share changes by steps, so that its derivative, where
/// there is one, is zero and says nothing.
pub struct Missed {
    of: Box<dyn Metric>,
    length: f64,
}

impl ShapeLoss for Missed {
    fn value(&self, points: &[DVec3], goal: &[DVec3]) -> f64 {
        if !is_finite(points) || !is_finite(goal) {
            return f64::INFINITY;
        }
        // Of samplings and of matched goals alike: a share knows no rows.
        let share = self.of.evaluate(points, goal, Matching::Unmatched);
        share.map_or(f64::INFINITY, |share| self.length * (1.0 - share))
    }

    fn gradient(&self, points: &[DVec3], _: &[DVec3]) -> Vec<DVec3> {
        vec![DVec3::ZERO; points.len()]
    }

    fn has_gradient(&self) -> bool {
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metric::tests::cloud;
    use crate::metric::{CostSpec, Coverage, Inside, Iou};

    fn missed(of: &str) -> anyhow::Result<Box<dyn ShapeLoss>> {
        toml_edit::de::from_str::<CostSpec>(&format!("kind = 'missed'\n{of}")).unwrap().build()
    }

    #[test]
    fn it_falls_as_the_share_rises_and_is_nothing_on_the_goal_and_all_far_away() {
        let goal = cloud(60, 1);
        let shares: [(&str, &dyn Metric); 3] =
            [("iou", &Iou::default()), ("coverage", &Coverage::default()), ("inside", &Inside::default())];
        for (kind, share) in shares {
            let loss = missed(&format!("of = {{ kind = '{kind}' }}\nlength = 0.5")).unwrap();
            assert_eq!(loss.value(&goal, &goal), 0.0, "{kind}");
            let mut before = 0.0;
            for by in [0.2, 0.5, 1.5, 9.0] {
                let moved: Vec<DVec3> = goal.iter().map(|p| *p + DVec3::X * by).collect();
                let (value, is) = (loss.value(&moved, &goal), share.evaluate(&moved, &goal, Matching::Unmatched));
                assert!((value - 0.5 * (1.0 - is.unwrap())).abs() < 1e-15 && value >= before, "{kind} {by}: {value}");
                before = value;
            }
            assert_eq!(before, 0.5, "{kind}");
            let mut broken = goal.clone();
            broken[3].y = f64::NAN;
            assert_eq!((loss.value(&broken, &goal), loss.value(&[], &goal)), (f64::INFINITY, f64::INFINITY), "{kind}");
        }
    }

    #[test]
    fn what_is_no_share_or_has_no_size_is_refused() {
        for (text, part) in [
            ("of = { kind = 'emd' }", "no share"),
            ("of = { kind = 'iou' }\nlength = 0.0", "cost.length"),
            ("of = { kind = 'iou', voxel = -0.001 }", "voxel"),
            ("of = { kind = 'coverage', radius = 0.0 }", "radius"),
        ] {
            let sentence = missed(text).err().unwrap_or_else(|| panic!("{text}")).to_string();
            assert!(sentence.contains(part), "{sentence}");
        }
    }

    #[test]
    fn nothing_that_descends_is_built_on_it() {
        let share = "{ kind = 'missed', of = { kind = 'iou' } }";
        let aligned = format!("kind = 'aligned'\nof = {share}");
        let sentence = toml_edit::de::from_str::<CostSpec>(&aligned).unwrap().build().err().unwrap().to_string();
        assert!(sentence.contains("no gradient"), "{sentence}");
    }
}
