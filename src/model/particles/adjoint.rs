//! The adjoint of one control step, substep by substep backwards.
use super::interval::{Interval, Substep};
use super::{ParticleModel, ParticleState};
use crate::model::Adjoint;
use crate::model::correction::OutcomeGrad;
use crate::model::cotangent::StateGrad;
use crate::model::law::{Law, Rate, View, ViewGrad};
use crate::state::{Control, ControlGrad, Particles, ParticlesGrad, Pose, PoseGrad, SceneGrad, Twist};
use glam::DVec3;
use std::ops::Range;

/// Where derivatives are added by what the model owns; empty where nobody asks.
struct Owned<'a> {
    weights: &'a mut [f32],
    constants: &'a mut [f64],
}

/// What flows backwards through an interval.
struct Backward<'a> {
    interval: &'a Interval<'a>,
    particles: ParticlesGrad,
    past: Vec<Vec<DVec3>>,
    /// `∂J/∂(start poses)` and `∂J/∂(end poses)`.
    from: Vec<PoseGrad>,
    to: Vec<PoseGrad>,
    /// What one call of the laws adds, pulled back to `from` and `to` after it.
    poses: Vec<PoseGrad>,
    twists: Vec<Twist>,
}

impl Backward<'_> {
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
    fn corrections(&mut self, tape: &[Particles], weights: &mut [f32]) -> ParticlesGrad {
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

impl ParticleModel {
    /// With λ = `∂J/∂` of what follows: `λ_a = h (λ_v + h λ_x)`, `λ_v ← keep (λ_v + h λ_x) + (∂a/∂v)ᵀ λ_a`,
    /// `λ_x ← λ_x + (∂a/∂x)ᵀ λ_a`; held accelerations collect `Σ λ_a` and are pulled back once. Constants collect
    /// `(∂a/∂c)ᵀ λ_a`.
    fn pull(
        &self,
        state: &ParticleState,
        control: &Control,
        next: &[f64],
        mut owned: Owned<'_>,
    ) -> (Vec<f64>, ControlGrad) {
        let count = state.particles.len();
        let interval = Interval::new(self, state, control);
        let mut tape = Vec::with_capacity(self.substeps);
        let mut given = Vec::new();
        interval.correct(interval.advance(Some(&mut tape)), Some(&mut given));

        let StateGrad { particles, past: mut newer, poses: to } = StateGrad::read(next, count, state.past.len());
        // The next state remembers this one's velocities first, and then what this one does.
        newer.push(vec![DVec3::ZERO; count]);
        let velocities = newer.remove(0);
        let parts = state.poses.len();
        let nothing = vec![PoseGrad::default(); parts];
        let mut back = Backward {
            interval: &interval,
            particles,
            past: newer,
            from: nothing.clone(),
            to,
            poses: nothing,
            twists: vec![Twist::default(); parts],
        };
        let start = back.corrections(&given, owned.weights);
        let mut at_acceleration = vec![DVec3::ZERO; count];
        let mut at_held = vec![DVec3::ZERO; count];
        let mut poses: Vec<Pose> = Vec::with_capacity(parts);
        let mut by_start = vec![DVec3::ZERO; if state.rigid.is_empty() { 0 } else { count }];
        for (k, Substep { start, lists, rigid }) in tape.iter().enumerate().rev() {
            for (rows, motion) in state.rigid.iter().zip(rigid) {
                motion.pull(rows, interval.h, &mut back.particles, &mut by_start);
            }
            if let Some(by_keep) = owned.constants.first_mut() {
                *by_keep += interval.keep_vjp(start, &back.particles);
            }
            let ParticlesGrad { positions, velocities } = &mut back.particles;
            for (i, (x, v)) in positions.iter().zip(velocities).enumerate() {
                let push = *v + interval.h * *x;
                *v = interval.keep * push;
                at_acceleration[i] = interval.h * push;
                at_held[i] += at_acceleration[i];
            }
            interval.place(k, &mut poses);
            let view = |law: &dyn Law| interval.view(start, lists.of(law.reach()), &poses);
            back.laws(Rate::Substep, view, &at_acceleration, interval.fraction(k), &mut owned);
            for (x, by) in back.particles.positions.iter_mut().zip(&mut by_start) {
                *x += std::mem::take(by);
            }
        }
        if let Some((graph, _)) = &interval.held {
            let view = |_: &dyn Law| interval.view(&state.particles, graph, &control.poses);
            back.laws(Rate::Step, view, &at_held, 1.0, &mut owned);
        }
        let ParticlesGrad { positions: by_positions, velocities: by_velocities } = start;
        back.particles.positions.iter_mut().zip(by_positions).for_each(|(own, by)| *own += by);
        back.particles
            .velocities
            .iter_mut()
            .zip(velocities)
            .zip(by_velocities)
            .for_each(|((own, next), by)| *own += next + by);
        let at_state = StateGrad { particles: back.particles, past: back.past, poses: back.from };
        (at_state.flat(), ControlGrad { poses: back.to })
    }
}

impl Adjoint<ParticleState> for ParticleModel {
    fn step_vjp(
        &self,
        state: &ParticleState,
        control: &Control,
        next: &[f64],
        weights: &mut [f32],
    ) -> (Vec<f64>, ControlGrad) {
        self.pull(state, control, next, Owned { weights, constants: &mut [] })
    }

    fn constants(&self) -> Vec<String> {
        let laws =
            self.names.iter().zip(&self.laws).flat_map(|(name, law)| {
                law.constants().into_iter().map(move |constant| format!("laws.{name}.{constant}"))
            });
        std::iter::once("keep".to_owned()).chain(laws).collect()
    }

    fn constants_vjp(
        &self,
        state: &ParticleState,
        control: &Control,
        next: &[f64],
        constants: &mut [f64],
    ) -> (Vec<f64>, ControlGrad) {
        self.pull(state, control, next, Owned { weights: &mut [], constants })
    }

    fn decode_vjp(&self, state: &ParticleState, particles: &ParticlesGrad) -> Vec<f64> {
        let particles = ParticlesGrad {
            positions: state.order.gather(&particles.positions),
            velocities: state.order.gather(&particles.velocities),
        };
        StateGrad::of(particles, state.past.len(), state.poses.len()).flat()
    }

    fn encode_vjp(&self, start: &ParticleState, at_start: &[f64], _: &mut [f32]) -> SceneGrad {
        let StateGrad { particles, poses, .. } = StateGrad::read(at_start, start.particles.len(), start.past.len());
        let particles = ParticlesGrad {
            positions: start.order.scatter(&particles.positions),
            velocities: start.order.scatter(&particles.velocities),
        };
        SceneGrad { particles, poses }
    }
}
