//! What flows backwards through one control step, and how laws and corrections pull on it.
use super::interval::Interval;
use super::tape::Asked;
use crate::model::correction::OutcomeGrad;
use crate::model::law::{Law, Rate, View, ViewGrad};
use crate::state::{Particles, ParticlesGrad, Pose, PoseGrad, Twist};
use glam::DVec3;
use std::ops::Range;

/// Where derivatives are added by what the model owns; empty where nobody asks.
pub(super) struct Owned<'a> {
    pub(super) weights: &'a mut [f32],
    pub(super) constants: &'a mut [f64],
}

/// What flows backwards through an interval.
pub(super) struct Backward<'a> {
    pub(super) interval: &'a Interval<'a>,
    pub(super) particles: ParticlesGrad,
    pub(super) past: Vec<Vec<DVec3>>,
    /// `∂J/∂(start poses)` and `∂J/∂(end poses)`.
    pub(super) from: Vec<PoseGrad>,
    pub(super) to: Vec<PoseGrad>,
    /// What one call of the laws adds, pulled back to `from` and `to` after it.
    poses: Vec<PoseGrad>,
    twists: Vec<Twist>,
    /// Room for the tool's poses.
    places: Vec<Pose>,
}

impl<'a> Backward<'a> {
    /// At the end of an interval, from the derivative by what it leads to.
    pub(super) fn new(
        interval: &'a Interval<'a>,
        particles: ParticlesGrad,
        past: Vec<Vec<DVec3>>,
        to: Vec<PoseGrad>,
    ) -> Self {
        let nothing = vec![PoseGrad::default(); to.len()];
        let twists = vec![Twist::default(); to.len()];
        Self { interval, particles, past, from: nothing.clone(), to, poses: nothing, twists, places: Vec::new() }
    }

    /// Pulls `at` = `∂J/∂acceleration` back through the laws of substeps as they were asked.
    pub(super) fn ask(&mut self, asked: &Asked, at: &[DVec3], owned: &mut Owned<'_>) {
        let interval = self.interval;
        let mut poses = std::mem::take(&mut self.places);
        interval.place(asked.fraction, &mut poses);
        let view = |law: &dyn Law| interval.view(&asked.particles, asked.lists.of(law.reach()), &poses);
        self.laws(Rate::Substep, view, at, asked.fraction, owned);
        self.places = poses;
    }

    /// Pulls `at` = `∂J/∂acceleration` back through the laws that were asked once.
    pub(super) fn held(&mut self, at: &[DVec3], owned: &mut Owned<'_>) {
        let Interval { state, control, held, .. } = self.interval;
        if let Some((graph, _)) = held {
            let interval = self.interval;
            let view = |_: &dyn Law| interval.view(&state.particles, graph, &control.poses);
            self.laws(Rate::Step, view, at, 1.0, owned);
        }
    }

    /// Pulls `at` = `∂J/∂acceleration` back through the laws of one rate, each with its own view, the tool a `fraction` of its
    /// way.
    fn laws<'v>(
        &mut self,
        rate: Rate,
        view: impl Fn(&dyn Law) -> View<'v>,
        at: &[DVec3],
        fraction: f64,
        owned: &mut Owned<'_>,
    ) {
        for (law, spans) in self.interval.model.laws(rate) {
            if !owned.constants.is_empty() {
                law.constants_vjp(&view(law), at, &mut owned.constants[spans.constants.clone()]);
            }
            let own = if owned.weights.is_empty() { 0..0 } else { spans.weights.clone() };
            let mut grad = ViewGrad {
                particles: std::mem::take(&mut self.particles),
                past: std::mem::take(&mut self.past),
                poses: std::mem::take(&mut self.poses),
                twists: std::mem::take(&mut self.twists),
                weights: &mut owned.weights[own],
            };
            law.accelerate_vjp(&view(law), at, &mut grad);
            (self.particles, self.past) = (grad.particles, grad.past);
            (self.poses, self.twists) = (grad.poses, grad.twists);
        }
        self.settle(fraction);
    }

    /// Pulls `∂J/∂particles` at the end of the interval back through the corrections, each given what `tape` says; returns
    /// `∂J/∂particles` at its start as far as corrections look at them.
    pub(super) fn corrections(&mut self, tape: &[Particles], weights: &mut [f32]) -> ParticlesGrad {
        let count = self.particles.positions.len();
        let mut start = ParticlesGrad::zero(count);
        for ((correction, span), given) in self.interval.model.corrections().zip(tape).rev() {
            let own: Range<usize> = if weights.is_empty() { 0..0 } else { span.clone() };
            let before = ViewGrad {
                particles: start,
                past: std::mem::take(&mut self.past),
                poses: std::mem::take(&mut self.poses),
                twists: std::mem::take(&mut self.twists),
                weights: &mut weights[own],
            };
            let at = std::mem::take(&mut self.particles);
            let mut grad = OutcomeGrad { before, predicted: ParticlesGrad::zero(count) };
            self.interval.outcome(given, |outcome| correction.correct_vjp(outcome, &at, &mut grad));
            (start, self.particles) = (grad.before.particles, grad.predicted);
            (self.past, self.poses, self.twists) = (grad.before.past, grad.before.poses, grad.before.twists);
        }
        self.settle(1.0);
        start
    }

    /// Pulls what was added to the tool, a `fraction` of its way, back to the ends of its way.
    fn settle(&mut self, fraction: f64) {
        let Interval { state, control, .. } = self.interval;
        for (i, (from, to)) in state.poses.iter().zip(&control.poses).enumerate() {
            let (pose, twist) = (std::mem::take(&mut self.poses[i]), std::mem::take(&mut self.twists[i]));
            if (pose, twist) != (PoseGrad::default(), Twist::default()) {
                let (at_from, at_to) = from.toward_vjp(to, fraction, &pose, &twist, state.interval);
                self.from[i] += at_from;
                self.to[i] += at_to;
            }
        }
    }
}
