//! What everyone but a model's author holds: rollouts and their gradients, written once for every [`Dynamics`].
use super::Dynamics;
use crate::state::{Control, ControlGrad, Particles, ParticlesGrad, Rollout, Scene, SceneGrad};
use crate::tool::Motion;
use rayon::prelude::*;
use std::path::Path;

/// A scalar cost on a rollout's states, `J = Σₜ ℓₜ(xₜ)`, with its derivative.
pub trait Cost: Sync {
    /// `ℓₜ(xₜ)` of the state after `t` of `horizon` steps.
    fn at(&self, t: usize, horizon: usize, particles: &Particles) -> f64;
    /// `∂ℓₜ/∂xₜ`.
    fn gradient(&self, t: usize, horizon: usize, particles: &Particles) -> ParticlesGrad;

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
    /// J and `∂J/∂u`, or `None` when the model has no adjoint.
    fn gradient(&self, scene: &Scene, controls: &[Control], cost: &dyn Cost) -> Option<Gradient>;
    /// J, `∂J/∂u` and `∂J/∂weights`, or `None` when the model has no adjoint.
    fn weight_gradient(&self, scene: &Scene, controls: &[Control], cost: &dyn Cost) -> Option<Gradient>;
    /// See [`Dynamics::weights`].
    fn weights(&self) -> Vec<f32>;
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
        let horizon = motions.first().map_or(0, |m| m.controls.len());
        let start = |motion: &Motion| self.encode(&Scene { poses: motion.start.clone(), ..scene.clone() });
        let mut states: Vec<D::State> = motions.par_iter().map(start).collect();
        let mut rollouts: Vec<Rollout> = states.iter().map(|x| vec![self.decode(x)]).collect();
        for t in 0..horizon {
            let controls: Vec<_> = motions.iter().map(|m| &m.controls[t]).collect();
            states = self.step_batch(&states, &controls);
            for (rollout, x) in rollouts.iter_mut().zip(&states) {
                rollout.push(self.decode(x));
            }
        }
        rollouts
    }

    fn gradient(&self, scene: &Scene, controls: &[Control], cost: &dyn Cost) -> Option<Gradient> {
        sweep(self, scene, controls, cost, Vec::new())
    }

    fn weight_gradient(&self, scene: &Scene, controls: &[Control], cost: &dyn Cost) -> Option<Gradient> {
        sweep(self, scene, controls, cost, vec![0.0; Dynamics::weights(self).len()])
    }

    fn weights(&self) -> Vec<f32> {
        Dynamics::weights(self)
    }

    fn set_weights(&mut self, weights: &[f32]) {
        Dynamics::set_weights(self, weights);
    }

    fn save_weights(&self, path: &Path) -> anyhow::Result<()> {
        Dynamics::save_weights(self, path)
    }
}

/// Forward through the steps, then backward; only states are kept, each step's tape lives for that step alone.
fn sweep<D: Dynamics>(
    model: &D,
    scene: &Scene,
    controls: &[Control],
    cost: &dyn Cost,
    mut weights: Vec<f32>,
) -> Option<Gradient> {
    let adjoint = model.adjoint()?;
    let horizon = controls.len();
    let mut states = vec![model.encode(scene)];
    for control in controls {
        states.push(model.step(states.last().expect("the encoded start"), control));
    }
    let decoded: Vec<_> = states.iter().map(|x| model.decode(x)).collect();
    let pull = |t: usize| adjoint.decode_vjp(&states[t], &cost.gradient(t, horizon, &decoded[t]));
    let mut at_state = pull(horizon);
    let mut at_controls = vec![ControlGrad::default(); horizon];
    for t in (0..horizon).rev() {
        let (back, control) = adjoint.step_vjp(&states[t], &controls[t], &at_state, &mut weights);
        at_controls[t] = control;
        at_state = pull(t);
        at_state.iter_mut().zip(&back).for_each(|(a, b)| *a += b);
    }
    let scene = adjoint.encode_vjp(&states[0], &at_state, &mut weights);
    Some(Gradient { cost: cost.total(&decoded), scene, controls: at_controls, weights })
}
