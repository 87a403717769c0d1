//! The adjoint of one control step: its end first, then its substeps backwards.
use super::backward::{Backward, Owned};
use super::interval::Interval;
use super::tape::Tape;
use super::{ParticleModel, ParticleState};
use crate::model::cotangent::StateGrad;
use crate::model::law::{self, History, Rate};
use crate::model::net::Wanted;
use crate::model::{Adjoint, Traced};
use crate::state::{Control, ControlGrad, ParticlesGrad, SceneGrad};
use glam::DVec3;

/// Numbers that laws remember, which follow those of [`StateGrad`] in the flat list.
fn numbers(histories: &[History]) -> usize {
    histories.iter().map(|history| history.values().len()).sum()
}

impl ParticleModel {
    /// Whether any derivative of a control step depends on where its substeps lead.
    fn looks_within(&self, state: &ParticleState) -> bool {
        self.laws(Rate::Substep).next().is_some() || !state.rigid.is_empty() || !self.corrections.is_empty()
    }

    /// From the end of `interval`, whose held laws left these traces.
    ///
    /// The corrections first, then the substeps, whose held accelerations collect `Σ λ_a` that is pulled back once; constants collect
    /// `(∂a/∂c)ᵀ λ_a`.
    fn pull(
        &self,
        interval: &Interval<'_>,
        traced: Vec<Option<law::Traced<'_>>>,
        next: &[f64],
        mut owned: Owned<'_>,
    ) -> (Vec<f64>, ControlGrad) {
        let state = interval.state;
        let count = state.particles.len();
        let mut tape = Tape::default();
        let mut given = Vec::new();
        let (predicted, histories) = self.integrator.advance(interval, Some(&mut tape));
        interval.correct(predicted, Some(&mut given));
        let (next, mut remembered) = next.split_at(next.len() - numbers(&histories));

        let StateGrad { particles, past: mut newer, poses: to } = StateGrad::read(next, count, state.past.len());
        // The next state remembers this one's velocities first, and then what this one does.
        newer.push(vec![DVec3::ZERO; count]);
        let velocities = newer.remove(0);
        let mut back = Backward::new(interval, particles, newer, to);
        back.histories = histories
            .iter()
            .map(|history| remembered.split_off(..history.values().len()).unwrap_or_default().to_vec())
            .collect();
        let start = back.corrections(&given, owned.weights);
        let mut at_held = vec![DVec3::ZERO; count];
        self.integrator.pull(&mut back, &tape, &mut at_held, &mut owned);
        back.held(&at_held, traced, &mut owned);
        let ParticlesGrad { positions: by_positions, velocities: by_velocities } = start;
        back.particles.positions.iter_mut().zip(by_positions).for_each(|(own, by)| *own += by);
        back.particles
            .velocities
            .iter_mut()
            .zip(velocities)
            .zip(by_velocities)
            .for_each(|((own, next), by)| *own += next + by);
        let at_state = StateGrad { particles: back.particles, past: back.past, poses: back.from };
        let mut flat = at_state.flat();
        flat.extend(back.histories.iter().flatten());
        (flat, ControlGrad { poses: back.to })
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
        let mut interval = Interval::unasked(self, state, control);
        // A network is the dearest law: it is not asked again for what no derivative depends on.
        if self.looks_within(state) {
            interval.hold();
        }
        self.pull(&interval, Vec::new(), next, Owned { weights, constants: &mut [] })
    }

    fn trace(
        &self,
        state: &ParticleState,
        control: &Control,
        wanted: Wanted,
    ) -> Option<(ParticleState, Traced<'_, ParticleState>)> {
        self.laws(Rate::Step).next()?;
        let mut interval = Interval::unasked(self, state, control);
        let laws = interval.trace(self, wanted);
        let next = interval.end();
        let bytes = laws.iter().flatten().map(|law| law.bytes).sum();
        let held = interval.held?;
        let pull = move |state: &_, control: &_, next: &[f64], weights: &mut [f32]| {
            let interval = Interval::holding(self, state, control, held);
            self.pull(&interval, laws, next, Owned { weights, constants: &mut [] })
        };
        Some((next, Traced { bytes, pull: Box::new(pull) }))
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
        let interval = Interval::new(self, state, control);
        self.pull(&interval, Vec::new(), next, Owned { weights: &mut [], constants })
    }

    fn decode_vjp(&self, state: &ParticleState, particles: &ParticlesGrad) -> Vec<f64> {
        let particles = ParticlesGrad {
            positions: state.order.gather(&particles.positions),
            velocities: state.order.gather(&particles.velocities),
        };
        let mut flat = StateGrad::of(particles, state.past.len(), state.poses.len()).flat();
        flat.resize(flat.len() + numbers(&state.histories), 0.0);
        flat
    }

    fn encode_vjp(&self, start: &ParticleState, at_start: &[f64], _: &mut [f32]) -> SceneGrad {
        let (at_start, mut remembered) = at_start.split_at(at_start.len() - numbers(&start.histories));
        let StateGrad { mut particles, poses, .. } = StateGrad::read(at_start, start.particles.len(), start.past.len());
        for (law, history) in self.laws.iter().zip(&start.histories) {
            let at = remembered.split_off(..history.values().len()).unwrap_or_default();
            if let Some(memory) = law.remembers() {
                memory.begin_vjp(&start.particles, history, at, &mut particles);
            }
        }
        let particles = ParticlesGrad {
            positions: start.order.scatter(&particles.positions),
            velocities: start.order.scatter(&particles.velocities),
        };
        SceneGrad { particles, poses }
    }
}
