//! What everyone but a model's author holds: rollouts and their gradients, written once for every [`Dynamics`].
use super::backward::{Back, Step, sweep};
use super::law::Message;
use super::net::Wanted;
use super::{Adjoint, Dynamics, Traced};
use crate::state::{Control, ControlGrad, Particles, ParticlesGrad, Rollout, Scene, SceneGrad, Snapshot};
use crate::tool::Motion;
use rayon::prelude::*;
use std::path::Path;

/// A scalar cost on a rollout's states, `J = Σₜ ℓₜ(xₜ)`, with its derivative.
pub trait Cost: Sync {
    /// `ℓₜ(xₜ)` of the state after `t` of `horizon` steps.
    fn at(&self, t: usize, horizon: usize, particles: &Particles) -> f64;
    /// `∂ℓₜ/∂xₜ`.
    fn gradient(&self, t: usize, horizon: usize, particles: &Particles) -> ParticlesGrad;

    /// Whether that derivative says where the cost falls, which it does not of one that changes by steps.
    fn has_gradient(&self) -> bool {
        true
    }

    /// J of a whole rollout.
    fn total(&self, rollout: &[Particles]) -> f64 {
        rollout.iter().enumerate().map(|(t, x)| self.at(t, rollout.len() - 1, x)).sum()
    }
}

/// J and its derivatives.
#[derive(Clone, Debug)]
pub struct Gradient {
    /// J.
    pub cost: f64,
    /// `∂J/∂scene`.
    pub scene: SceneGrad,
    /// `∂J/∂uₜ`, one per step.
    pub controls: Vec<ControlGrad>,
    /// `∂J/∂weights`, flat; empty unless asked for.
    pub weights: Vec<f32>,
}

/// J and its derivatives by the constants of a model's config.
#[derive(Clone, Debug, PartialEq)]
pub struct ConstantGradient {
    /// J.
    pub cost: f64,
    /// `∂J/∂constants`, in the order of [`WorldModel::constants`].
    pub constants: Vec<f64>,
}

/// Any [`Dynamics`] with its state type erased: what planners, trainers and evaluators hold.
pub trait WorldModel: Send + Sync {
    /// See [`Dynamics::accepts`].
    ///
    /// # Errors
    /// A sentence saying what the scene lacks.
    fn accepts(&self, scene: &Scene) -> anyhow::Result<()>;
    /// The states that follow `scene` under `controls`, the start included.
    fn rollout(&self, scene: &Scene, controls: &[Control]) -> Rollout;
    /// One rollout per motion, each from `scene` with the tool at that motion's start; motions have equal lengths.
    fn rollouts(&self, scene: &Scene, motions: &[Motion]) -> Vec<Rollout>;
    /// One rollout per pair of a scene and a motion, as [`WorldModel::rollouts`] gives it, and the simulator's state at its end
    /// where the model has one: with it the next motion can be predicted from there. Motions have equal lengths.
    fn follow(&self, scenes: &[Scene], motions: &[Motion]) -> Vec<(Rollout, Option<Snapshot>)> {
        let one = |(scene, motion): (&Scene, &Motion)| {
            (self.rollout(&Scene { poses: motion.start.clone(), ..scene.clone() }, &motion.controls), None)
        };
        scenes.iter().zip(motions).map(one).collect()
    }
    /// J and `∂J/∂u`, or `None` when the model has no adjoint.
    fn gradient(&self, scene: &Scene, controls: &[Control], cost: &dyn Cost) -> Option<Gradient>;
    /// J, `∂J/∂u` and `∂J/∂weights`, or `None` when the model has no adjoint.
    fn weight_gradient(&self, scene: &Scene, controls: &[Control], cost: &dyn Cost) -> Option<Gradient>;
    /// Paths into the model's config of the constants that it has derivatives by, see [`Adjoint::constants`].
    fn constants(&self) -> Vec<String> {
        Vec::new()
    }
    /// J and `∂J/∂constants`, or `None` when the model has no adjoint.
    ///
    /// The derivative goes back through at most `truncation` steps, in pieces that each take their start as given (truncated
    /// backpropagation, Williams & Peng 1990); it is exact where that is no less than the number of controls.
    fn constant_gradient(
        &self,
        scene: &Scene,
        controls: &[Control],
        cost: &dyn Cost,
        truncation: usize,
    ) -> Option<ConstantGradient> {
        let _ = (scene, controls, cost, truncation);
        None
    }
    /// See [`Dynamics::messages`].
    fn messages(&self, _scene: &Scene, _control: &Control) -> Vec<Message> {
        Vec::new()
    }
    /// See [`Dynamics::messages_vjp`].
    fn messages_vjp(&self, scene: &Scene, control: &Control, at: &[[f64; 2]], weights: &mut [f32]) {
        let _ = (scene, control, weights);
        assert!(at.is_empty(), "a model that sends messages has no derivatives of them");
    }
    /// See [`Dynamics::weights`].
    fn weights(&self) -> Vec<f32>;
    /// See [`Dynamics::matrices`].
    fn matrices(&self) -> Vec<(String, usize)> {
        Vec::new()
    }
    /// See [`Dynamics::set_weights`].
    fn set_weights(&mut self, weights: &[f32]);
    /// See [`Dynamics::save_weights`].
    ///
    /// # Errors
    /// When there are none, or the file cannot be written.
    fn save_weights(&self, path: &Path) -> anyhow::Result<()>;
}

impl<D: Dynamics> WorldModel for D {
    fn accepts(&self, scene: &Scene) -> anyhow::Result<()> {
        Dynamics::accepts(self, scene)
    }

    fn rollout(&self, scene: &Scene, controls: &[Control]) -> Rollout {
        let mut state = self.encode(scene);
        let mut rollout = vec![self.decode(&state)];
        for control in controls {
            state = self.step(&state, control);
            rollout.push(self.decode(&state));
        }
        rollout
    }

    fn rollouts(&self, scene: &Scene, motions: &[Motion]) -> Vec<Rollout> {
        advance(self, motions.par_iter().map(|_| scene), motions).0
    }

    fn follow(&self, scenes: &[Scene], motions: &[Motion]) -> Vec<(Rollout, Option<Snapshot>)> {
        let (rollouts, states) = advance(self, scenes.par_iter(), motions);
        rollouts.into_iter().zip(states.par_iter().map(|x| self.snapshot(x)).collect::<Vec<_>>()).collect()
    }

    fn gradient(&self, scene: &Scene, controls: &[Control], cost: &dyn Cost) -> Option<Gradient> {
        with_weights(self, scene, controls, cost, Vec::new())
    }

    fn weight_gradient(&self, scene: &Scene, controls: &[Control], cost: &dyn Cost) -> Option<Gradient> {
        with_weights(self, scene, controls, cost, vec![0.0; Dynamics::weights(self).len()])
    }

    fn constants(&self) -> Vec<String> {
        self.adjoint().map_or_else(Vec::new, |adjoint| adjoint.constants())
    }

    fn constant_gradient(
        &self,
        scene: &Scene,
        controls: &[Control],
        cost: &dyn Cost,
        truncation: usize,
    ) -> Option<ConstantGradient> {
        let mut constants = vec![0.0; WorldModel::constants(self).len()];
        let swept = sweep(self, scene, controls, cost, truncation, Constants(&mut constants))?;
        Some(ConstantGradient { cost: swept.cost, constants })
    }

    fn messages(&self, scene: &Scene, control: &Control) -> Vec<Message> {
        Dynamics::messages(self, scene, control)
    }

    fn messages_vjp(&self, scene: &Scene, control: &Control, at: &[[f64; 2]], weights: &mut [f32]) {
        Dynamics::messages_vjp(self, scene, control, at, weights);
    }

    fn weights(&self) -> Vec<f32> {
        Dynamics::weights(self)
    }

    fn matrices(&self) -> Vec<(String, usize)> {
        Dynamics::matrices(self)
    }

    fn set_weights(&mut self, weights: &[f32]) {
        Dynamics::set_weights(self, weights);
    }

    fn save_weights(&self, path: &Path) -> anyhow::Result<()> {
        Dynamics::save_weights(self, path)
    }
}

/// The rollouts of `motions`, each from its own scene, and the states at their ends.
fn advance<'a, D: Dynamics>(
    model: &D,
    scenes: impl IndexedParallelIterator<Item = &'a Scene>,
    motions: &[Motion],
) -> (Vec<Rollout>, Vec<D::State>) {
    let horizon = motions.first().map_or(0, |m| m.controls.len());
    let start =
        |(scene, motion): (&Scene, &Motion)| model.encode(&Scene { poses: motion.start.clone(), ..scene.clone() });
    let mut states: Vec<D::State> = scenes.zip(motions).map(start).collect();
    let mut rollouts: Vec<Rollout> = states.iter().map(|x| vec![model.decode(x)]).collect();
    for t in 0..horizon {
        let controls: Vec<_> = motions.iter().map(|m| &m.controls[t]).collect();
        states = model.step_batch(&states, &controls);
        for (rollout, x) in rollouts.iter_mut().zip(&states) {
            rollout.push(model.decode(x));
        }
    }
    (rollouts, states)
}

/// Goes back with `∂J/∂weights`, unless there are none.
struct Weights<'a>(&'a mut [f32]);

impl<S> Back<S> for Weights<'_> {
    fn trace<'a>(&self, adjoint: &'a dyn Adjoint<S>, state: &S, control: &Control) -> Option<(S, Traced<'a, S>)> {
        adjoint.trace(state, control, Wanted::of(self.0))
    }

    fn pull(&mut self, step: Step<'_, S>, next: &[f64]) -> (Vec<f64>, ControlGrad) {
        let Step { adjoint, state, control, traced } = step;
        match traced {
            Some(traced) => (traced.pull)(state, control, next, self.0),
            None => adjoint.step_vjp(state, control, next, self.0),
        }
    }
}

/// Goes back with `∂J/∂constants`.
struct Constants<'a>(&'a mut [f64]);

impl<S> Back<S> for Constants<'_> {
    fn pull(&mut self, step: Step<'_, S>, next: &[f64]) -> (Vec<f64>, ControlGrad) {
        step.adjoint.constants_vjp(step.state, step.control, next, self.0)
    }
}

fn with_weights<D: Dynamics>(
    model: &D,
    scene: &Scene,
    controls: &[Control],
    cost: &dyn Cost,
    mut weights: Vec<f32>,
) -> Option<Gradient> {
    let swept = sweep(model, scene, controls, cost, controls.len(), Weights(&mut weights))?;
    let scene = model.adjoint()?.encode_vjp(&swept.start, &swept.at_start, &mut weights);
    Some(Gradient { cost: swept.cost, scene, controls: swept.controls, weights })
}
