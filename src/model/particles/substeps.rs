//! The laws of every substep, asked one time after the other.
use super::interval::Interval;
use super::neighbours::Neighbours;
use super::tape::{Asked, Tape};
use crate::model::law::{Law, Rate};
use crate::state::{Particles, Pose};
use glam::DVec3;
use std::sync::Arc;

/// What is carried from one time that they are asked to the next.
pub(super) struct Substeps<'a> {
    interval: &'a Interval<'a>,
    laws: Vec<&'a dyn Law>,
    neighbours: Neighbours,
    poses: Vec<Pose>,
}

impl<'a> Substeps<'a> {
    /// At the start of an interval.
    pub(super) fn new(interval: &'a Interval<'a>) -> Self {
        let laws: Vec<&dyn Law> = interval.model.laws(Rate::Substep).map(|(law, _)| law).collect();
        let reaches = laws.iter().map(|law| law.reach()).collect();
        let neighbours = Neighbours::new(reaches, &interval.state.particles.positions);
        Self { interval, laws, neighbours, poses: Vec::with_capacity(interval.state.poses.len()) }
    }

    /// Writes the acceleration of `particles`, with the tool a `fraction` of its way, to `out`, and what was asked onto the tape.
    pub(super) fn ask(&mut self, particles: &Particles, fraction: f64, out: &mut [DVec3], tape: Option<&mut Tape>) {
        match &self.interval.held {
            Some((_, held)) => out.copy_from_slice(held),
            None => out.fill(DVec3::ZERO),
        }
        let lists = self.neighbours.at(&particles.positions);
        if !self.laws.is_empty() {
            self.interval.place(fraction, &mut self.poses);
        }
        for law in &self.laws {
            law.accelerate(&self.interval.view(particles, lists.of(law.reach()), &self.poses), out);
        }
        if let Some(tape) = tape {
            tape.asked.push(Asked { particles: particles.clone(), lists: Arc::clone(lists), fraction });
        }
    }
}
