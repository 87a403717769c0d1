//! Contact between particles: they push when they overlap, and rub when they slide.
use super::compliant::{COMPLIANT, CompliantSpec};
use super::pair::{Pair, Pairwise};
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Config of [`Contact`]: two particles overlap by `δ = 2 R − r`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct ContactSpec(pub CompliantSpec);

impl ContactSpec {
    pub(crate) fn build(self) -> anyhow::Result<Pairwise<Contact>> {
        self.0.check("contact")?;
        Ok(Pairwise(Contact(self.0)))
    }
}

/// The compliant contact of two equal balls; `n` points from j to i.
pub struct Contact(CompliantSpec);

impl Pair for Contact {
    fn reach(&self) -> f64 {
        2.0 * self.0.radius
    }

    #[inline]
    fn acceleration(&self, offset: DVec3, square: f64, velocity: DVec3) -> DVec3 {
        let distance = square.sqrt();
        self.0.acceleration(2.0 * self.0.radius - distance, offset / distance, velocity)
    }

    #[inline]
    fn pull(&self, offset: DVec3, square: f64, velocity: DVec3, at: DVec3) -> (DVec3, DVec3) {
        let distance = square.sqrt();
        let normal = offset / distance;
        let by = self.0.pull(2.0 * self.0.radius - distance, normal, velocity, at);
        let turning = (by.normal - normal * normal.dot(by.normal)) / distance;
        (turning - by.overlap * normal, by.velocity)
    }

    fn constants(&self) -> &[&'static str] {
        &COMPLIANT
    }

    fn pull_constants(&self, offset: DVec3, square: f64, velocity: DVec3, at: DVec3, constants: &mut [f64]) {
        let distance = square.sqrt();
        let mut by = self.0.pull_constants(2.0 * self.0.radius - distance, offset / distance, velocity, at);
        by[0] *= 2.0;
        constants.iter_mut().zip(by).for_each(|(sum, by)| *sum += by);
    }
}
