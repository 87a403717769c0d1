//! The floor of every comparison: nothing moves.
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

/// Cotangents are flat: positions 3N, then velocities 3N.
impl Adjoint<StillState> for Still {
    fn step_vjp(&self, state: &StillState, control: &Control, next: &[f64], _: &mut [f32]) -> (Vec<f64>, ControlGrad) {
        let mut back = next.to_vec();
        back[3 * state.particles.len()..].fill(0.0);
        (back, ControlGrad { poses: vec![PoseGrad::default(); control.poses.len()] })
    }

    fn decode_vjp(&self, _: &StillState, particles: &ParticlesGrad) -> Vec<f64> {
        particles.positions.iter().chain(&particles.velocities).flat_map(|v| v.to_array()).collect()
    }

    fn encode_vjp(&self, start: &StillState, at_start: &[f64], _: &mut [f32]) -> SceneGrad {
        let rows: Vec<DVec3> = at_start.chunks_exact(3).map(DVec3::from_slice).collect();
        let (positions, velocities) = rows.split_at(start.particles.len());
        let particles = ParticlesGrad { positions: positions.to_vec(), velocities: velocities.to_vec() };
        SceneGrad { particles, poses: vec![PoseGrad::default(); start.parts] }
    }
}
