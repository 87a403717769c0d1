//! A weighted sum of Chamfer and earth mover's distance.
use super::{Chamfer, Emd, ShapeLoss};
use anyhow::ensure;
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Config of [`Weighted`]; RoboCook's loss is one half each.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WeightedSpec {
    /// Weight of the Chamfer distance.
    #[schemars(range(min = 0.0))]
    pub chamfer: f64,
    /// Weight of the earth mover's distance.
    #[schemars(range(min = 0.0))]
    pub emd: f64,
}

impl WeightedSpec {
    pub(crate) fn build(self) -> anyhow::Result<Weighted> {
        for (key, weight) in [("chamfer", self.chamfer), ("emd", self.emd)] {
            ensure!(weight >= 0.0 && weight.is_finite(), "cost.{key} must be a weight of at least 0, got {weight}");
        }
        ensure!(self.chamfer + self.emd > 0.0, "cost.chamfer and cost.emd are both 0: nothing would be minimised");
        Ok(Weighted { chamfer: self.chamfer, emd: self.emd })
    }
}

/// `w_c Chamfer + w_e EMD` \[m\].
#[derive(Clone, Copy, Debug)]
pub struct Weighted {
    chamfer: f64,
    emd: f64,
}

impl ShapeLoss for Weighted {
    fn value(&self, points: &[DVec3], goal: &[DVec3]) -> f64 {
        self.parts().iter().map(|(weight, loss)| weight * loss.value(points, goal)).sum()
    }

    fn gradient(&self, points: &[DVec3], goal: &[DVec3]) -> Vec<DVec3> {
        let mut out = vec![DVec3::ZERO; points.len()];
        for (weight, loss) in self.parts() {
            out.iter_mut().zip(loss.gradient(points, goal)).for_each(|(o, g)| *o += weight * g);
        }
        out
    }
}

impl Weighted {
    /// The terms that count; an assignment that nobody weighs is not solved, and `0 · ∞` is not asked.
    fn parts(&self) -> Vec<(f64, &'static dyn ShapeLoss)> {
        let all: [(f64, &'static dyn ShapeLoss); 2] = [(self.chamfer, &Chamfer), (self.emd, &Emd)];
        all.into_iter().filter(|(weight, _)| *weight > 0.0).collect()
    }
}
