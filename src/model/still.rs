//! The floor of every comparison: nothing moves.
use super::cotangent::StateGrad;
use super::{Adjoint, Dynamics};
use crate::state::{Control, ControlGrad, Particles, ParticlesGrad, PoseGrad, Scene, SceneGrad};
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Config of [`Still`], which has nothing to choose.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StillSpec {}

impl StillSpec {
    pub(crate) fn build(self) -> anyhow::Result<Still> {
        Ok(Still)
    }
}

/// The model that predicts no motion, `xₜ₊₁ = xₜ`, `vₜ₊₁ = 0`.
pub struct Still;

/// Particles, and how many parts the tool has that does not matter.
#[derive(Clone, Debug)]
pub struct StillState {
    particles: Particles,
    parts: usize,
}

impl Dynamics for Still {
    type State = StillState;

    fn encode(&self, scene: &Scene) -> StillState {
        StillState { particles: scene.particles.clone(), parts: scene.poses.len() }
    }

    fn step(&self, state: &StillState, _: &Control) -> StillState {
        StillState { particles: Particles::at_rest(state.particles.positions.clone()), parts: state.parts }
    }

    fn decode(&self, state: &StillState) -> Particles {
        state.particles.clone()
    }

    fn adjoint(&self) -> Option<&dyn Adjoint<StillState>> {
        Some(self)
    }
}

impl Adjoint<StillState> for Still {
    fn step_vjp(&self, state: &StillState, control: &Control, next: &[f64], _: &mut [f32]) -> (Vec<f64>, ControlGrad) {
        let mut back = StateGrad::read(next, state.particles.len(), 0);
        back.particles.velocities.fill(DVec3::ZERO);
        (back.flat(), ControlGrad { poses: vec![PoseGrad::default(); control.poses.len()] })
    }

    fn decode_vjp(&self, state: &StillState, particles: &ParticlesGrad) -> Vec<f64> {
        StateGrad::of(particles.clone(), 0, state.parts).flat()
    }

    fn encode_vjp(&self, start: &StillState, at_start: &[f64], _: &mut [f32]) -> SceneGrad {
        let StateGrad { particles, poses, .. } = StateGrad::read(at_start, start.particles.len(), 0);
        SceneGrad { particles, poses }
    }
}
