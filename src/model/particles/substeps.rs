//! The laws of every substep, asked one time after the other.
use super::Spans;
use super::interval::Interval;
use super::neighbours::Neighbours;
use super::tape::{Asked, Tape};
use crate::model::law::{History, Law, Rate, View};
use crate::state::{Particles, Pose};
use glam::DVec3;
use std::sync::Arc;

/// What is carried from one time that they are asked to the next.
pub(super) struct Substeps<'a> {
    interval: &'a Interval<'a>,
    laws: Vec<(&'a dyn Law, &'a Spans)>,
    neighbours: Neighbours,
    poses: Vec<Pose>,
    /// What each law of the model remembers.
    histories: Vec<History>,
}

/// When the laws are asked.
#[derive(Clone, Copy)]
pub(super) struct Moment {
    /// How far the tool has come, of its way.
    pub(super) fraction: f64,
    /// Time since they were asked before \[s\].
    pub(super) duration: f64,
}

impl<'a> Substeps<'a> {
    /// At the start of an interval.
    pub(super) fn new(interval: &'a Interval<'a>) -> Self {
        let laws: Vec<_> = interval.model.laws(Rate::Substep).collect();
        let reaches = laws.iter().map(|(law, _)| law.reach()).collect();
        let neighbours = Neighbours::new(reaches, &interval.state.particles.positions);
        let poses = Vec::with_capacity(interval.state.poses.len());
        Self { interval, laws, neighbours, poses, histories: interval.state.histories.clone() }
    }

    /// Writes the acceleration of `particles` to `out`, once every law remembers what it is to, and what was asked onto the tape.
    pub(super) fn ask(&mut self, particles: &Particles, moment: Moment, out: &mut [DVec3], tape: Option<&mut Tape>) {
        match &self.interval.held {
            Some((_, held)) => out.copy_from_slice(held),
            None => out.fill(DVec3::ZERO),
        }
        let lists = self.neighbours.at(&particles.positions);
        if !self.laws.is_empty() {
            self.interval.place(moment.fraction, &mut self.poses);
        }
        let before = tape.is_some().then(|| self.histories.clone());
        for (law, spans) in &self.laws {
            let history = &mut self.histories[spans.place];
            let view = self.interval.view(particles, lists.of(law.reach()), &self.poses);
            if let Some(memory) = law.remembers() {
                *history = memory.advance(&View { history, ..view }, moment.duration);
            }
            law.accelerate(&View { history, ..view }, out);
        }
        if let (Some(tape), Some(before)) = (tape, before) {
            let (after, lists, Moment { fraction, duration }) = (self.histories.clone(), Arc::clone(lists), moment);
            tape.asked.push(Asked { particles: particles.clone(), lists, fraction, duration, before, after });
        }
    }

    /// What every law remembers at the end.
    pub(super) fn remembered(self) -> Vec<History> {
        self.histories
    }
}
