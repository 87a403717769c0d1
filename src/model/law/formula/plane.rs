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
    ///
    /// A particle is written before it is known to be within reach and overwritten if it is not: that needs no branch.
    #[inline]
    fn blocks(&self, view: &View<'_>, meetings: &mut Meetings<'_>, mut full: impl FnMut(&[u32], &mut Meetings<'_>)) {
        (0..BLOCK).for_each(|k| meetings.normal.set(k, self.normal));
        let (mut waiting, mut count) = ([0; BLOCK], 0);
        for (i, (position, velocity)) in view.particles.positions.iter().zip(&view.particles.velocities).enumerate() {
            let distance = self.normal.dot(*position) - self.offset;
            // The remainder is the count itself; it spares the bounds checks.
            let k = count % BLOCK;
            waiting[k] = i as u32;
            meetings.distance[k] = distance;
            meetings.velocity.set(k, *velocity);
            count += usize::from(distance < meetings.reach());
            if count == BLOCK {
                full(&waiting, meetings);
                count = 0;
            }
        }
        if count > 0 {
            full(&waiting[..count], meetings);
        }
    }
}

impl Law for Plane {
    fn accelerate(&self, view: &View<'_>, out: &mut [DVec3]) {
        self.blocks(view, &mut Meetings::forward(&self.programs), |particles, meetings| {
            meetings.accelerate();
            particles.iter().enumerate().for_each(|(k, i)| out[*i as usize] += meetings.acceleration.get(k));
        });
    }

    fn accelerate_vjp(&self, view: &View<'_>, out: &[DVec3], grad: &mut ViewGrad<'_>) {
        self.blocks(view, &mut Meetings::adjoint(&self.programs), |particles, meetings| {
            particles.iter().enumerate().for_each(|(k, i)| meetings.acceleration.set(k, out[*i as usize]));
            meetings.pull();
            for (k, i) in particles.iter().enumerate() {
                let by = meetings.gradient(k);
                grad.particles.positions[*i as usize] -= by.overlap * self.normal;
                grad.particles.velocities[*i as usize] += by.velocity;
            }
        });
    }

    fn constants(&self) -> Vec<&str> {
        self.programs.constants()
    }

    fn constants_vjp(&self, view: &View<'_>, out: &[DVec3], constants: &mut [f64]) {
        self.blocks(view, &mut Meetings::constants(&self.programs), |particles, meetings| {
            particles.iter().enumerate().for_each(|(k, i)| meetings.acceleration.set(k, out[*i as usize]));
            meetings.pull_constants(particles.len(), constants);
        });
    }
}
