//! The table, a compliant plane z = 0, and walls alike.
use super::compliant::CompliantSpec;
use super::history::Remember;
use super::tangential::Touch;
use super::touching::{self, Meeting, MeetingGrad, Touching};
use super::{Law, View, ViewGrad};
use crate::state::Wall;
use glam::{DMat3, DVec3};
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
    fn remembers(&self) -> Option<&dyn Remember> {
        self.0.springs().then_some(self as &dyn Remember)
    }

    fn stable(&self) -> f64 {
        self.0.stable()
    }

    fn accelerate(&self, view: &View<'_>, out: &mut [DVec3]) {
        if self.0.springs() {
            return touching::accelerate(self, view, out);
        }
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
        if self.0.springs() {
            return touching::accelerate_vjp(self, view, out, grad);
        }
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
        self.0.constants().to_vec()
    }

    fn constants_vjp(&self, view: &View<'_>, out: &[DVec3], constants: &mut [f64]) {
        if self.0.springs() {
            return touching::constants_vjp(self, view, out, constants);
        }
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

impl Floor {
    /// Calls `visit` with every particle that touches a plane, and that plane's normal.
    fn each(&self, view: &View<'_>, mut visit: impl FnMut(&Meeting)) {
        for (pushed, (position, velocity)) in
            view.particles.positions.iter().zip(&view.particles.velocities).enumerate()
        {
            for (number, plane) in planes(view).enumerate() {
                let overlap = self.0.radius - plane.distance(*position);
                if overlap > 0.0 {
                    let touch = Touch { overlap, normal: plane.normal, velocity: *velocity };
                    let pair = [pushed as u32, number as u32];
                    visit(&Meeting { pair, pushed, opposite: None, touch, frame: DMat3::IDENTITY });
                }
            }
        }
    }
}

impl Touching for Floor {
    const RADII: f64 = 1.0;

    fn spec(&self) -> &CompliantSpec {
        &self.0
    }

    fn meet(&self, view: &View<'_>, visit: &mut dyn FnMut(&Meeting)) {
        self.each(view, visit);
    }

    fn pull(&self, view: &View<'_>, grad: &mut ViewGrad<'_>, visit: &mut dyn FnMut(&Meeting) -> MeetingGrad) {
        self.each(view, |meeting| {
            let by = visit(meeting).contact;
            grad.particles.positions[meeting.pushed] -= by.overlap * meeting.touch.normal;
            grad.particles.velocities[meeting.pushed] += by.velocity;
        });
    }
}

/// The table and the walls.
fn planes<'a>(view: &View<'a>) -> impl Iterator<Item = &'a Wall> {
    std::iter::once(&Wall::FLOOR).chain(view.walls)
}
