//! Gravity.
use super::{Law, View, ViewGrad};
use anyhow::ensure;
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Config of [`Gravity`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GravitySpec {
    /// Acceleration towards the table \[m/s²\].
    pub acceleration: f64,
}

impl GravitySpec {
    pub(crate) fn build(self) -> anyhow::Result<Gravity> {
        ensure!(
            self.acceleration.is_finite(),
            "acceleration of the law \"gravity\" must be finite, got {}",
            self.acceleration
        );
        Ok(Gravity(self.acceleration))
    }
}

/// The same acceleration for every particle, `a = −g ẑ`.
pub struct Gravity(f64);

impl Law for Gravity {
    fn accelerate(&self, _: &View<'_>, out: &mut [DVec3]) {
        out.iter_mut().for_each(|a| a.z -= self.0);
    }

    fn accelerate_vjp(&self, _: &View<'_>, _: &[DVec3], _: &mut ViewGrad<'_>) {}

    fn constants(&self) -> Vec<&str> {
        vec!["acceleration"]
    }

    fn constants_vjp(&self, _: &View<'_>, out: &[DVec3], constants: &mut [f64]) {
        constants[0] -= out.iter().map(|a| a.z).sum::<f64>();
    }
}
