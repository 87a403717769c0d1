//! Cohesion: neighbours that do not touch attract.
use super::compliant::{not_negative, positive, swing};
use super::pair::{Pair, Pairwise};
use anyhow::ensure;
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Config of [`Cohesion`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CohesionSpec {
    /// Greatest attraction c, the acceleration of one particle by one neighbour \[m/s²\].
    #[schemars(range(min = 0.0))]
    pub strength: f64,
    /// Distance r₀ of two centres below which there is none, usually twice the contact radius \[m\].
    #[schemars(range(min = 0.0))]
    pub contact: f64,
    /// Distance r₁ of two centres beyond which there is none \[m\].
    #[schemars(range(min = 1e-6))]
    pub reach: f64,
}

impl CohesionSpec {
    pub(crate) fn build(self) -> anyhow::Result<Pairwise<Cohesion>> {
        not_negative("cohesion", "strength", self.strength)?;
        not_negative("cohesion", "contact", self.contact)?;
        positive("cohesion", "reach", self.reach)?;
        ensure!(
            self.reach > self.contact,
            "reach of the law \"cohesion\" ({}) must exceed its contact distance ({})",
            self.reach,
            self.contact
        );
        Ok(Pairwise(Cohesion { inverse: (self.reach - self.contact).recip(), spec: self }))
    }
}

/// `a = −c w(s) x/r` with `w(s) = 16 s² (1 − s)²`, `s = (r − r₀)/(r₁ − r₀)` in \[0, 1\]: greatest midway, smooth at both ends.
pub struct Cohesion {
    spec: CohesionSpec,
    inverse: f64,
}

impl Pair for Cohesion {
    fn reach(&self) -> f64 {
        self.spec.reach
    }

    /// The steepest slope of w(s) is `16/(3√3)`.
    fn stable(&self) -> f64 {
        swing(2.0 * self.spec.strength * self.inverse * 16.0 / 27.0_f64.sqrt())
    }

    #[inline]
    fn acceleration(&self, offset: DVec3, square: f64, _: DVec3) -> DVec3 {
        if square <= self.spec.contact * self.spec.contact {
            return DVec3::ZERO;
        }
        let distance = square.sqrt();
        let s = (distance - self.spec.contact) * self.inverse;
        let bump = 4.0 * s * (1.0 - s);
        offset * (-self.spec.strength * bump * bump / distance)
    }

    #[inline]
    fn pull(&self, offset: DVec3, square: f64, _: DVec3, at: DVec3) -> (DVec3, DVec3) {
        if square <= self.spec.contact * self.spec.contact {
            return (DVec3::ZERO, DVec3::ZERO);
        }
        let distance = square.sqrt();
        let s = (distance - self.spec.contact) * self.inverse;
        let bump = 4.0 * s * (1.0 - s);
        let pull = -self.spec.strength * bump * bump;
        let slope = -self.spec.strength * 8.0 * bump * (1.0 - 2.0 * s) * self.inverse;
        let normal = offset / distance;
        let along = at.dot(normal);
        (pull / distance * at + (slope - pull / distance) * along * normal, DVec3::ZERO)
    }

    fn constants(&self) -> &[&'static str] {
        &["strength", "contact", "reach"]
    }

    fn pull_constants(&self, offset: DVec3, square: f64, _: DVec3, at: DVec3, constants: &mut [f64]) {
        if square <= self.spec.contact * self.spec.contact {
            return;
        }
        let distance = square.sqrt();
        let s = (distance - self.spec.contact) * self.inverse;
        let bump = 4.0 * s * (1.0 - s);
        let along = at.dot(offset) / distance;
        let by_place = -self.spec.strength * 8.0 * bump * (1.0 - 2.0 * s) * along;
        constants[0] -= bump * bump * along;
        constants[1] -= by_place * (1.0 - s) * self.inverse;
        constants[2] -= by_place * s * self.inverse;
    }
}
