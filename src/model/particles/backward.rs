//! What flows backwards through one control step, and how laws and corrections pull on it.
use super::interval::Interval;
use super::tape::Asked;
use crate::model::correction::OutcomeGrad;
use crate::model::law::{Law, Rate, Traced, View, ViewGrad};
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
    /// By what each law of the model remembers.
    pub(super) histories: Vec<Vec<f64>>,
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
        let histories = Vec::new();
        Self {
            interval,
            particles,
            past,
            histories,
            from: nothing.clone(),
            to,
            poses: nothing,
            twists,
            places: Vec::new(),
        }
    }

    /// Pulls `at` = `∂J/∂acceleration` back through the laws of substeps as they were asked.
    pub(super) fn ask(&mut self, asked: &Asked, at: &[DVec3], owned: &mut Owned<'_>) {
        let interval = self.interval;
        let mut poses = std::mem::take(&mut self.places);
        interval.place(asked.fraction, &mut poses);
        let view = |law: &dyn Law, place: usize| View {
            history: &asked.after[place],
            ..interval.view(&asked.particles, asked.lists.of(law.reach()), &poses)
        };
        self.laws(Rate::Substep, view, at, Vec::new(), owned);
        for (law, spans) in interval.model.laws(Rate::Substep) {
            let Some(memory) = law.remembers() else { continue };
            let before = &asked.before[spans.place];
            let view = View { history: before, ..view(law, spans.place) };
            let at = std::mem::replace(&mut self.histories[spans.place], vec![0.0; before.values().len()]);
            if !owned.constants.is_empty() {
                let own = &mut owned.constants[spans.constants.clone()];
                memory.advance_constants_vjp(&view, asked.duration, &at, own);
            }
            self.grad(spans.place, &mut [], |grad| memory.advance_vjp(&view, asked.duration, &at, grad));
        }
        self.settle(asked.fraction);
        self.places = poses;
    }

    /// Pulls `at` = `∂J/∂acceleration` back through the laws that were asked once, by their traces where there are any.
    pub(super) fn held(&mut self, at: &[DVec3], traced: Vec<Option<Traced<'_>>>, owned: &mut Owned<'_>) {
        let Interval { state, control, held, .. } = self.interval;
        if let Some((graph, _)) = held {
            let interval = self.interval;
            let view = |_: &dyn Law, _: usize| interval.view(&state.particles, graph, &control.poses);
            self.laws(Rate::Step, view, at, traced, owned);
            self.settle(1.0);
        }
    }

    /// Pulls `at` = `∂J/∂acceleration` back through the laws of one rate, each with its own view.
    fn laws<'v>(
        &mut self,
        rate: Rate,
        view: impl Fn(&dyn Law, usize) -> View<'v>,
        at: &[DVec3],
        traced: Vec<Option<Traced<'_>>>,
        owned: &mut Owned<'_>,
    ) {
        let mut traced = traced.into_iter();
        for (law, spans) in self.interval.model.laws(rate) {
            if !owned.constants.is_empty() {
                law.constants_vjp(&view(law, spans.place), at, &mut owned.constants[spans.constants.clone()]);
            }
            let own = if owned.weights.is_empty() { 0..0 } else { spans.weights.clone() };
            let view = view(law, spans.place);
            let traced = traced.next().flatten();
            self.grad(spans.place, &mut owned.weights[own], |grad| match traced {
                Some(traced) => (traced.pull)(&view, at, grad),
                None => law.accelerate_vjp(&view, at, grad),
            });
        }
    }

    /// Lets `add` add to what flows backwards, of which the law at `place` sees its own memory.
    fn grad(&mut self, place: usize, weights: &mut [f32], add: impl FnOnce(&mut ViewGrad<'_>)) {
        let mut grad = ViewGrad {
            particles: std::mem::take(&mut self.particles),
            past: std::mem::take(&mut self.past),
            poses: std::mem::take(&mut self.poses),
            twists: std::mem::take(&mut self.twists),
            history: std::mem::take(&mut self.histories[place]),
            weights,
        };
        add(&mut grad);
        (self.particles, self.past) = (grad.particles, grad.past);
        (self.poses, self.twists) = (grad.poses, grad.twists);
        self.histories[place] = grad.history;
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
                history: Vec::new(),
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
