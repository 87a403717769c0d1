//! The table, a compliant plane z = 0, and walls alike.
use super::compliant::{COMPLIANT, CompliantSpec};
use super::{Law, View, ViewGrad};
use crate::state::Wall;
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Config of [`Floor`]: a particle sinks into the table by `δ = R − z`, and into a wall by R less its distance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct FloorSpec(pub CompliantSpec);

impl FloorSpec {
    pub(crate) fn build(self) -> anyhow::Result<Floor> {
        self.0.check("floor")?;
        Ok(Floor(self.0))
    }
}

/// The compliant contact of every particle with resting half spaces: the one below z = 0, and those behind walls.
pub struct Floor(CompliantSpec);

impl Law for Floor {
    fn accelerate(&self, view: &View<'_>, out: &mut [DVec3]) {
        let particles = view.particles.positions.iter().zip(&view.particles.velocities);
        for ((position, velocity), out) in particles.zip(out) {
            for plane in planes(view) {
                let overlap = self.0.radius - plane.distance(*position);
                if overlap > 0.0 {
                    *out += self.0.acceleration(overlap, plane.normal, *velocity);
                }
            }
        }
    }

    fn accelerate_vjp(&self, view: &View<'_>, out: &[DVec3], grad: &mut ViewGrad<'_>) {
        for (i, (position, velocity)) in view.particles.positions.iter().zip(&view.particles.velocities).enumerate() {
            for plane in planes(view) {
                let overlap = self.0.radius - plane.distance(*position);
                if overlap > 0.0 {
                    let by = self.0.pull(overlap, plane.normal, *velocity, out[i]);
                    grad.particles.positions[i] -= by.overlap * plane.normal;
                    grad.particles.velocities[i] += by.velocity;
                }
            }
        }
    }

    fn constants(&self) -> Vec<&str> {
        COMPLIANT.to_vec()
    }

    fn constants_vjp(&self, view: &View<'_>, out: &[DVec3], constants: &mut [f64]) {
        let particles = view.particles.positions.iter().zip(&view.particles.velocities);
        for ((position, velocity), at) in particles.zip(out) {
            for plane in planes(view) {
                let overlap = self.0.radius - plane.distance(*position);
                if overlap > 0.0 {
                    let by = self.0.pull_constants(overlap, plane.normal, *velocity, *at);
                    constants.iter_mut().zip(by).for_each(|(sum, by)| *sum += by);
                }
            }
        }
    }
}

/// The table and the walls.
fn planes<'a>(view: &View<'a>) -> impl Iterator<Item = &'a Wall> {
    std::iter::once(&Wall::FLOOR).chain(view.walls)
}
