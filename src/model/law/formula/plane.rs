//! Formulas between a particle and a resting plane.
use super::meeting::Meetings;
use super::programs::Programs;
use crate::model::formula::BLOCK;
use crate::model::law::{Law, View, ViewGrad};
use glam::DVec3;

/// The half space behind `n·x = offset`.
pub(super) struct Plane {
    programs: Programs,
    normal: DVec3,
    offset: f64,
}

impl Plane {
    pub(super) fn new(programs: Programs, normal: DVec3, offset: f64) -> Self {
        Self { programs, normal, offset }
    }

    /// Fills blocks with the particles within reach and gives each to `full`.
    fn blocks(&self, view: &View<'_>, meetings: &mut Meetings<'_>, mut full: impl FnMut(&[usize], &mut Meetings<'_>)) {
        (0..BLOCK).for_each(|k| meetings.normal.set(k, self.normal));
        let mut waiting = Vec::with_capacity(BLOCK);
        for (i, (position, velocity)) in view.particles.positions.iter().zip(&view.particles.velocities).enumerate() {
            let distance = self.normal.dot(*position) - self.offset;
            if distance < meetings.reach() {
                meetings.distance[waiting.len()] = distance;
                meetings.velocity.set(waiting.len(), *velocity);
                waiting.push(i);
            }
            if waiting.len() == BLOCK {
                full(&waiting, meetings);
                waiting.clear();
            }
        }
        if !waiting.is_empty() {
            full(&waiting, meetings);
        }
    }
}

impl Law for Plane {
    fn accelerate(&self, view: &View<'_>, out: &mut [DVec3]) {
        self.blocks(view, &mut Meetings::forward(&self.programs), |particles, meetings| {
            meetings.accelerate();
            particles.iter().enumerate().for_each(|(k, i)| out[*i] += meetings.acceleration.get(k));
        });
    }

    fn accelerate_vjp(&self, view: &View<'_>, out: &[DVec3], grad: &mut ViewGrad<'_>) {
        self.blocks(view, &mut Meetings::adjoint(&self.programs), |particles, meetings| {
            particles.iter().enumerate().for_each(|(k, i)| meetings.acceleration.set(k, out[*i]));
            meetings.pull();
            for (k, i) in particles.iter().enumerate() {
                let by = meetings.gradient(k);
                grad.particles.positions[*i] -= by.overlap * self.normal;
                grad.particles.velocities[*i] += by.velocity;
            }
        });
    }
}
