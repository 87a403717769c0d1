//! Models that see a picture from above, the height map and the tool over it, and tell how far what lies there moves.
//!
//! ```text
//! picture_c = [h_c / height, the tool's nearness and motion at every level]
//! field     = network(picture)                  a displacement at every cell and level
//! x ← x + scale · field(x),  v = (x' − x)/T      interpolated linearly
//! ```
//!
//! A particle rides on the field, so that what is predicted is still the same particle and nothing is lost. There is no momentum: what
//! is not pushed rests. Walls are not seen.
use super::cotangent::StateGrad;
use super::net::{Layers, Trainable, forward, pull};
use super::{Adjoint, Dynamics};
use crate::state::{
    Control, ControlGrad, Particles, ParticlesGrad, Pose, PoseGrad, Scene, SceneGrad, ToolShape, Twist,
};
use glam::DVec3;
use std::path::Path;
use std::sync::Arc;
use tool_view::{NUMBERS, ToolView};

mod grid;
mod spec;
mod tool_view;
mod top;

pub use grid::GridSpec;
pub use spec::PictureSpec;
pub(crate) use top::Top;

/// A model whose network maps the picture to the field of displacements.
pub(crate) struct HeightMapModel<N> {
    picture: PictureSpec,
    network: N,
}

/// Particles and the tool.
#[derive(Clone, Debug)]
pub(crate) struct HeightMapState {
    particles: Particles,
    tool: Arc<ToolShape>,
    poses: Vec<Pose>,
    interval: f64,
}

/// What one step sees.
struct Sighting<'a> {
    top: Top,
    tool: ToolView<'a>,
    picture: Vec<f32>,
}

impl<N: Layers + Trainable> HeightMapModel<N> {
    pub(super) fn new(picture: PictureSpec, network: N) -> Self {
        Self { picture, network }
    }

    fn twists(state: &HeightMapState, control: &Control) -> Vec<Twist> {
        state.poses.iter().zip(&control.poses).map(|(from, to)| from.twist_to(to, state.interval)).collect()
    }

    fn look<'a>(&'a self, state: &'a HeightMapState, control: &'a Control, twists: &'a [Twist]) -> Sighting<'a> {
        let PictureSpec { grid, reach, scale, top, .. } = &self.picture;
        let stride = self.picture.inputs();
        let top = Top::of(grid, *top, &state.particles.positions);
        let mut picture = vec![0.0; grid.size().cells() * stride];
        for (row, height) in picture.chunks_exact_mut(stride).zip(&top.heights) {
            row[0] = (height / grid.height) as f32;
        }
        let (tool, interval) = (&*state.tool, state.interval);
        let tool = ToolView { grid, tool, poses: &control.poses, twists, interval, reach: *reach, scale: *scale };
        tool.draw(&mut picture, stride);
        Sighting { top, tool, picture }
    }
}

impl<N: Layers + Trainable + Send + Sync> Dynamics for HeightMapModel<N> {
    type State = HeightMapState;

    fn accepts(&self, scene: &Scene) -> anyhow::Result<()> {
        scene.check()
    }

    fn encode(&self, scene: &Scene) -> HeightMapState {
        let (tool, poses) = (Arc::clone(&scene.tool), scene.poses.clone());
        HeightMapState { particles: scene.particles.clone(), tool, poses, interval: scene.interval }
    }

    fn step(&self, state: &HeightMapState, control: &Control) -> HeightMapState {
        let twists = Self::twists(state, control);
        let field = forward(&self.network, vec![(self.look(state, control, &twists).picture, self.picture.inputs())]);
        let PictureSpec { grid, scale, .. } = &self.picture;
        let positions = &state.particles.positions;
        let moves: Vec<DVec3> = positions.iter().map(|x| *scale * grid.read(&field, *x)).collect();
        let particles = Particles {
            positions: positions.iter().zip(&moves).map(|(x, d)| *x + *d).collect(),
            velocities: moves.iter().map(|d| *d / state.interval).collect(),
        };
        HeightMapState { particles, poses: control.poses.clone(), ..state.clone() }
    }

    fn decode(&self, state: &HeightMapState) -> Particles {
        state.particles.clone()
    }

    fn adjoint(&self) -> Option<&dyn Adjoint<HeightMapState>> {
        Some(self)
    }

    fn weights(&self) -> Vec<f32> {
        self.network.weights()
    }

    fn matrices(&self) -> Vec<(String, usize)> {
        self.network.matrices()
    }

    fn set_weights(&mut self, weights: &[f32]) {
        self.network.set_weights(weights);
    }

    fn save_weights(&self, path: &Path) -> anyhow::Result<()> {
        self.network.save(path)
    }
}

impl<N: Layers + Trainable + Send + Sync> Adjoint<HeightMapState> for HeightMapModel<N> {
    fn step_vjp(
        &self,
        state: &HeightMapState,
        control: &Control,
        next: &[f64],
        weights: &mut [f32],
    ) -> (Vec<f64>, ControlGrad) {
        let (PictureSpec { grid, scale, .. }, stride) = (&self.picture, self.picture.inputs());
        let positions = &state.particles.positions;
        let twists = Self::twists(state, control);
        let sighting = self.look(state, control, &twists);

        let StateGrad { particles: at, poses: mut to, .. } = StateGrad::read(next, positions.len(), 0);
        let rows = at.positions.iter().zip(&at.velocities);
        let at_moves: Vec<DVec3> = rows.map(|(x, v)| *scale * (*x + *v / state.interval)).collect();
        let mut at_field = vec![0.0_f32; grid.size().cells() * self.picture.outputs()];
        for (x, at_move) in positions.iter().zip(&at_moves) {
            grid.spread(&mut at_field, *x, *at_move);
        }
        let inputs = vec![(sighting.picture, stride)];
        let (field, mut at_inputs) = pull(&self.network, inputs, &at_field, weights);
        let at_picture = at_inputs.swap_remove(0);
        let mut back = ParticlesGrad { velocities: vec![DVec3::ZERO; positions.len()], positions: at.positions };
        for ((x, at_move), back) in positions.iter().zip(&at_moves).zip(&mut back.positions) {
            *back += grid.slope(&field, *x, *at_move);
        }
        let at_top: Vec<f64> = at_picture.chunks_exact(stride).map(|row| f64::from(row[0]) / grid.height).collect();
        sighting.top.pull(grid, positions, &at_top, &mut back.positions);

        let parts = state.poses.len();
        let (mut poses, mut at_twists) = (vec![PoseGrad::default(); parts], vec![Twist::default(); parts]);
        sighting.tool.pull(&at_picture, stride, &mut poses, &mut at_twists);
        let mut from = vec![PoseGrad::default(); parts];
        for (k, (pose, twist)) in poses.iter().zip(&at_twists).enumerate() {
            let (start, end) = (&state.poses[k], &control.poses[k]);
            let (at_start, at_end) = start.toward_vjp(end, 1.0, pose, twist, state.interval);
            from[k] = at_start;
            to[k] += at_end;
        }
        (StateGrad { particles: back, past: Vec::new(), poses: from }.flat(), ControlGrad { poses: to })
    }

    fn decode_vjp(&self, state: &HeightMapState, particles: &ParticlesGrad) -> Vec<f64> {
        StateGrad::of(particles.clone(), 0, state.poses.len()).flat()
    }

    fn encode_vjp(&self, start: &HeightMapState, at_start: &[f64], _: &mut [f32]) -> SceneGrad {
        let StateGrad { particles, poses, .. } = StateGrad::read(at_start, start.particles.len(), 0);
        SceneGrad { particles, poses }
    }
}
