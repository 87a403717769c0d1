//! The table: a compliant plane z = 0.
use super::compliant::CompliantSpec;
use super::{Law, View, ViewGrad};
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Config of [`Floor`]: a particle sinks into the table by `δ = R − z`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct FloorSpec(pub CompliantSpec);

impl FloorSpec {
    pub(crate) fn build(self) -> anyhow::Result<Floor> {
        self.0.check("floor")?;
        Ok(Floor(self.0))
    }
}

/// The compliant contact of every particle with a resting half space below z = 0.
pub struct Floor(CompliantSpec);

impl Law for Floor {
    fn accelerate(&self, view: &View<'_>, out: &mut [DVec3]) {
        let particles = view.particles.positions.iter().zip(&view.particles.velocities);
        for ((position, velocity), out) in particles.zip(out) {
            let overlap = self.0.radius - position.z;
            if overlap > 0.0 {
                *out += self.0.acceleration(overlap, DVec3::Z, *velocity);
            }
        }
    }

    fn accelerate_vjp(&self, view: &View<'_>, out: &[DVec3], grad: &mut ViewGrad<'_>) {
        for (i, (position, velocity)) in view.particles.positions.iter().zip(&view.particles.velocities).enumerate() {
            let overlap = self.0.radius - position.z;
            if overlap > 0.0 {
                let by = self.0.pull(overlap, DVec3::Z, *velocity, out[i]);
                grad.particles.positions[i].z -= by.overlap;
                grad.particles.velocities[i] += by.velocity;
            }
        }
    }
}
