//! Viscosity: neighbours resist approaching and parting.
use super::compliant::{not_negative, positive};
use super::pair::{Pair, Pairwise};
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Config of [`Viscosity`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ViscositySpec {
    /// Damping rate η of one pair at zero distance \[1/s\].
    #[schemars(range(min = 0.0))]
    pub rate: f64,
    /// Distance r₁ of two centres beyond which there is none \[m\].
    #[schemars(range(min = 1e-6))]
    pub reach: f64,
}

impl ViscositySpec {
    pub(crate) fn build(self) -> anyhow::Result<Pairwise<Viscosity>> {
        not_negative("viscosity", "rate", self.rate)?;
        positive("viscosity", "reach", self.reach)?;
        Ok(Pairwise(Viscosity { inverse: (self.reach * self.reach).recip(), spec: self }))
    }
}

/// `a = −η (1 − r²/r₁²)² (v·x) x / r²`: along the line of centres, so a rigid rotation is not damped and angular momentum is
/// kept (the dissipative force of Español & Warren 1995).
pub struct Viscosity {
    spec: ViscositySpec,
    inverse: f64,
}

impl Pair for Viscosity {
    fn reach(&self) -> f64 {
        self.spec.reach
    }

    /// `0.1 π/(2 η)`: a relative velocity decays at 2 η.
    fn stable(&self) -> f64 {
        0.1 * std::f64::consts::PI / (2.0 * self.spec.rate)
    }

    #[inline]
    fn acceleration(&self, offset: DVec3, square: f64, velocity: DVec3) -> DVec3 {
        let fade = 1.0 - square * self.inverse;
        offset * (-self.spec.rate * fade * fade * velocity.dot(offset) / square)
    }

    #[inline]
    fn pull(&self, offset: DVec3, square: f64, velocity: DVec3, at: DVec3) -> (DVec3, DVec3) {
        let fade = 1.0 - square * self.inverse;
        let weight = -self.spec.rate * fade * fade / square;
        // d weight / d square, times two for d square / d offset = 2 offset.
        let slope = 2.0 * self.spec.rate * fade * (2.0 * self.inverse * square + fade) / (square * square);
        let (closing, along) = (velocity.dot(offset), at.dot(offset));
        let by_offset = weight * (closing * at + along * velocity) + slope * closing * along * offset;
        (by_offset, weight * along * offset)
    }

    fn constants(&self) -> &[&'static str] {
        &["rate", "reach"]
    }

    fn pull_constants(&self, offset: DVec3, square: f64, velocity: DVec3, at: DVec3, constants: &mut [f64]) {
        let fade = 1.0 - square * self.inverse;
        let both = velocity.dot(offset) * at.dot(offset);
        constants[0] -= fade * fade * both / square;
        constants[1] -= 4.0 * self.spec.rate * fade * both * self.inverse / self.spec.reach;
    }
}
