//! What a model's author writes.
use super::Checkpoints;
use super::law::Message;
use super::net::Wanted;
use crate::state::{Control, ControlGrad, Particles, ParticlesGrad, Scene, SceneGrad, Snapshot};
use rayon::prelude::*;
use std::path::Path;

/// How a state changes when a tool moves. A new model implements this.
pub trait Dynamics: Send + Sync {
    /// What the model carries from step to step: particles, a history, a latent vector.
    type State: Clone + Send + Sync;

    /// Whether this model can start from `scene`; called before any rollout.
    ///
    /// # Errors
    /// A sentence saying what the scene lacks.
    fn accepts(&self, _: &Scene) -> anyhow::Result<()> {
        Ok(())
    }

    /// Reads an accepted scene once, at the start of a rollout.
    fn encode(&self, scene: &Scene) -> Self::State;
    /// Advances the state by one control interval.
    fn step(&self, state: &Self::State, control: &Control) -> Self::State;
    /// The particles this state stands for, in the scene's order.
    fn decode(&self, state: &Self::State) -> Particles;

    /// The simulator's own state in this one, for a model that can only start from there.
    fn snapshot(&self, _: &Self::State) -> Option<Snapshot> {
        None
    }

    /// Advances many states at once, in parallel; every state's result is the one `step` gives.
    fn step_batch(&self, states: &[Self::State], controls: &[&Control]) -> Vec<Self::State> {
        states.par_iter().zip(controls).map(|(x, u)| self.step(x, u)).collect()
    }

    /// The adjoint of this model, if it has one.
    fn adjoint(&self) -> Option<&dyn Adjoint<Self::State>> {
        None
    }

    /// The messages of the laws that send any, at the start of an interval.
    fn messages(&self, _scene: &Scene, _control: &Control) -> Vec<Message> {
        Vec::new()
    }
    /// Adds `∂J/∂weights` to `weights` from `∂J/∂(N, T)` of every message, in the order of [`Dynamics::messages`].
    fn messages_vjp(&self, scene: &Scene, control: &Control, at: &[[f64; 2]], weights: &mut [f32]) {
        let _ = (scene, control, weights);
        assert!(at.is_empty(), "a model that sends messages has no derivatives of them");
    }

    /// Which states of a rollout its gradient keeps.
    fn checkpoints(&self) -> Checkpoints {
        Checkpoints::default()
    }

    /// Trainable weights, flat; empty when nothing is learned.
    fn weights(&self) -> Vec<f32> {
        Vec::new()
    }

    /// Name of each weight matrix, as the file of weights has it, and how many weights it holds, in the order of
    /// [`Dynamics::weights`]; empty where they have none.
    fn matrices(&self) -> Vec<(String, usize)> {
        Vec::new()
    }

    /// Replaces the trainable weights by `weights`, laid out as [`Dynamics::weights`].
    fn set_weights(&mut self, weights: &[f32]) {
        assert!(weights.is_empty(), "a model without weights was given some");
    }

    /// Writes the weights by name to a file that the model's config can name.
    ///
    /// # Errors
    /// When there are none, or the file cannot be written.
    fn save_weights(&self, path: &Path) -> anyhow::Result<()> {
        anyhow::bail!("{} cannot be written: the model has no weights", path.display())
    }
}

/// [`Adjoint::step_vjp`] of the step that it was traced in, with what it would otherwise compute again.
pub struct Traced<'a, S> {
    /// Memory that it holds.
    pub bytes: usize,
    /// The derivative.
    pub pull: TracedPull<'a, S>,
}

/// See [`Adjoint::step_vjp`].
pub type TracedPull<'a, S> = Box<dyn FnOnce(&S, &Control, &[f64], &mut [f32]) -> (Vec<f64>, ControlGrad) + 'a>;

/// Reverse-mode derivatives of a [`Dynamics`], one step at a time.
pub trait Adjoint<S> {
    /// `(∂J/∂xₜ, ∂J/∂uₜ)` from `∂J/∂xₜ₊₁`; adds `∂J/∂weights` to `weights` unless that slice is empty.
    fn step_vjp(&self, state: &S, control: &Control, next: &[f64], weights: &mut [f32]) -> (Vec<f64>, ControlGrad);
    /// What [`Dynamics::step`] gives and the wanted derivatives there, of a model whose [`Adjoint::step_vjp`] would compute much of the
    /// step again; the same bits.
    fn trace(&self, state: &S, control: &Control, wanted: Wanted) -> Option<(S, Traced<'_, S>)> {
        let _ = (state, control, wanted);
        None
    }
    /// Paths into the model's config of the constants that it has derivatives by, such as `laws.contact.stiffness`.
    fn constants(&self) -> Vec<String> {
        Vec::new()
    }
    /// As [`Adjoint::step_vjp`], but adds `∂J/∂constants`, in the order of [`Adjoint::constants`], to `constants`.
    fn constants_vjp(
        &self,
        state: &S,
        control: &Control,
        next: &[f64],
        constants: &mut [f64],
    ) -> (Vec<f64>, ControlGrad) {
        assert!(constants.is_empty(), "a model that names constants has no derivatives by them");
        self.step_vjp(state, control, next, &mut [])
    }
    /// `∂J/∂x` from `∂J/∂particles`.
    fn decode_vjp(&self, state: &S, particles: &ParticlesGrad) -> Vec<f64>;
    /// `∂J/∂scene` from `∂J/∂x₀`, `start` being the encoded scene; adds `∂J/∂weights` to `weights` unless that slice is empty.
    fn encode_vjp(&self, start: &S, at_start: &[f64], weights: &mut [f32]) -> SceneGrad;
}
