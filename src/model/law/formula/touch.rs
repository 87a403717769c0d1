//! Formulas between a particle and a part of the tool, through the part's signed distance.
use super::meeting::Meetings;
use super::programs::Programs;
use crate::model::formula::BLOCK;
use crate::model::law::tool::Touch;
use crate::model::law::{Law, View, ViewGrad};
use crate::model::placed::Placed;
use glam::DVec3;

/// The law of every particle with every part that it touches.
pub(super) struct Touched(pub(super) Programs);

impl Touched {
    /// Gives `full` the touches of a scene, a block at a time.
    fn blocks(
        &self,
        view: &View<'_>,
        meetings: &mut Meetings<'_>,
        mut full: impl FnMut(&[Touch<'_>], &mut Meetings<'_>),
    ) {
        let parts = Placed::all(view, self.0.reach);
        let mut touches = Vec::new();
        Placed::touches(&parts, &view.particles.positions, |touch| touches.push(touch));
        for block in touches.chunks(BLOCK) {
            for (k, touch) in block.iter().enumerate() {
                meetings.distance[k] = touch.distance();
                meetings.normal.set(k, touch.normal());
                meetings.velocity.set(k, touch.velocity(view));
            }
            full(block, meetings);
        }
    }
}

impl Law for Touched {
    fn accelerate(&self, view: &View<'_>, out: &mut [DVec3]) {
        self.blocks(view, &mut Meetings::forward(&self.0), |touches, meetings| {
            meetings.accelerate();
            touches.iter().enumerate().for_each(|(k, touch)| out[touch.particle] += meetings.acceleration.get(k));
        });
    }

    fn accelerate_vjp(&self, view: &View<'_>, out: &[DVec3], grad: &mut ViewGrad<'_>) {
        self.blocks(view, &mut Meetings::adjoint(&self.0), |touches, meetings| {
            touches.iter().enumerate().for_each(|(k, touch)| meetings.acceleration.set(k, out[touch.particle]));
            meetings.pull();
            touches.iter().enumerate().for_each(|(k, touch)| touch.pull(&meetings.gradient(k), grad));
        });
    }

    fn constants(&self) -> Vec<&str> {
        self.0.constants()
    }

    fn constants_vjp(&self, view: &View<'_>, out: &[DVec3], constants: &mut [f64]) {
        self.blocks(view, &mut Meetings::constants(&self.0), |touches, meetings| {
            touches.iter().enumerate().for_each(|(k, touch)| meetings.acceleration.set(k, out[touch.particle]));
            meetings.pull_constants(touches.len(), constants);
        });
    }
}
