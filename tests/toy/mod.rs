//! A small model with three weights and a hand-written adjoint, and a world made of it.
#![allow(dead_code, reason = "each test file uses its own part")]
use glam::DVec3;
use pliant::data::Episode;
use pliant::model::{Adjoint, Dynamics, WorldModel};
use pliant::state::{
    Control, ControlGrad, Part, Particles, ParticlesGrad, Pose, PoseGrad, Scene, SceneGrad, Solid, SurfacePoint,
    ToolShape,
};
use pliant::train::{Split, Tools};
use pliant::watch::Watch;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::sync::Arc;

/// Width of the tool's influence [m].
const WIDTH: f64 = 0.03;
/// Duration of a step [s].
pub(crate) const INTERVAL: f64 = 0.1;

/// `d = w₀ T v + w₁ exp(−|x − p|²/ℓ²) (p' − p) + w₂ c`, then `x' = x + d`, `v' = d/T`.
pub(crate) struct Toy {
    pub(crate) weights: Vec<f32>,
    /// Asks the watch to stop when the weights have been replaced so often.
    pub(crate) stop: Option<(Watch, usize)>,
}

impl Toy {
    pub(crate) fn new(weights: [f32; 3]) -> Self {
        Self { weights: weights.to_vec(), stop: None }
    }

    fn w(&self, i: usize) -> f64 {
        f64::from(self.weights[i])
    }
}

#[derive(Clone)]
pub(crate) struct ToyState {
    particles: Particles,
    tool: DVec3,
}

fn lift() -> DVec3 {
    DVec3::new(0.0, 0.0, 1e-3)
}

fn influence(x: DVec3, tool: DVec3) -> f64 {
    (-(x - tool).length_squared() / (WIDTH * WIDTH)).exp()
}

impl Dynamics for Toy {
    type State = ToyState;

    fn encode(&self, scene: &Scene) -> ToyState {
        ToyState { particles: scene.particles.clone(), tool: scene.poses[0].translation }
    }

    fn step(&self, state: &ToyState, control: &Control) -> ToyState {
        let to = control.poses[0].translation;
        let mut next = ToyState { particles: state.particles.clone(), tool: to };
        let Particles { positions, velocities } = &mut next.particles;
        for (x, v) in positions.iter_mut().zip(velocities) {
            let push = influence(*x, state.tool) * (to - state.tool);
            let d = self.w(0) * INTERVAL * *v + self.w(1) * push + self.w(2) * lift();
            *x += d;
            *v = d / INTERVAL;
        }
        next
    }

    fn decode(&self, state: &ToyState) -> Particles {
        state.particles.clone()
    }

    fn adjoint(&self) -> Option<&dyn Adjoint<ToyState>> {
        Some(self)
    }

    fn weights(&self) -> Vec<f32> {
        self.weights.clone()
    }

    fn matrices(&self) -> Vec<(String, usize)> {
        ["keep", "push", "lift"].map(|name| (name.to_owned(), 1)).to_vec()
    }

    fn set_weights(&mut self, weights: &[f32]) {
        self.weights.copy_from_slice(weights);
        if let Some((watch, left)) = &mut self.stop {
            *left -= 1;
            if *left == 0 {
                watch.stop();
                self.stop = None;
            }
        }
    }
}

impl Adjoint<ToyState> for Toy {
    fn step_vjp(
        &self,
        state: &ToyState,
        control: &Control,
        next: &[f64],
        weights: &mut [f32],
    ) -> (Vec<f64>, ControlGrad) {
        let push = control.poses[0].translation - state.tool;
        let count = state.particles.len();
        let row = |i: usize| DVec3::from_slice(&next[3 * i..3 * i + 3]);
        let (mut positions, mut velocities) = (Vec::new(), Vec::new());
        for (i, (x, v)) in state.particles.positions.iter().zip(&state.particles.velocities).enumerate() {
            let (at_x, at_d) = (row(i), row(i) + row(count + i) / INTERVAL);
            let k = influence(*x, state.tool);
            if let [w0, w1, w2] = weights {
                *w0 += (INTERVAL * v.dot(at_d)) as f32;
                *w1 += (k * push.dot(at_d)) as f32;
                *w2 += lift().dot(at_d) as f32;
            }
            positions.push(at_x - self.w(1) * push.dot(at_d) * 2.0 * k / (WIDTH * WIDTH) * (*x - state.tool));
            velocities.push(self.w(0) * INTERVAL * at_d);
        }
        let back = positions.iter().chain(&velocities).flat_map(|v| v.to_array()).collect();
        (back, ControlGrad { poses: vec![PoseGrad::default()] })
    }

    fn decode_vjp(&self, _: &ToyState, particles: &ParticlesGrad) -> Vec<f64> {
        particles.positions.iter().chain(&particles.velocities).flat_map(|v| v.to_array()).collect()
    }

    fn encode_vjp(&self, start: &ToyState, _: &[f64], _: &mut [f32]) -> SceneGrad {
        SceneGrad { particles: ParticlesGrad::zero(start.particles.len()), poses: vec![PoseGrad::default()] }
    }
}

/// `count` episodes of `steps` steps that `model` makes under random straight pushes through a cloud.
pub(crate) fn episodes(model: &Toy, count: usize, steps: usize, seed: u64) -> Vec<Episode> {
    (0..count)
        .map(|e| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(e as u64);
            let mut spread = |half: f64| DVec3::from_array(std::array::from_fn(|_| rng.random_range(-half..half)));
            let positions = (0..12).map(|_| spread(0.03)).collect();
            let (from, to) = (spread(0.04), spread(0.04));
            let pose = |s: f64| Pose { translation: from.lerp(to, s), ..Pose::default() };
            let controls: Vec<Control> =
                (1..=steps).map(|t| Control { poses: vec![pose(t as f64 / steps as f64)] }).collect();
            let scene = Scene::open(Particles::at_rest(positions), shape(), vec![pose(0.0)], INTERVAL);
            Episode {
                tool: "pusher".to_owned(),
                theta: Vec::new(),
                interval: INTERVAL,
                start: scene.poses.clone(),
                states: model.rollout(&scene, &controls),
                controls,
                body: [0; 12].into(),
                walls: [].into(),
                constants: Default::default(),
            }
        })
        .collect()
}

/// Training and held-out episodes of one world.
pub(crate) fn split(model: &Toy) -> Split {
    Split { train: episodes(model, 8, 6, 1), held_out: episodes(model, 3, 6, 2), tools: tools() }
}

pub(crate) fn tools() -> Tools {
    Tools::from([("pusher".to_owned(), shape())])
}

fn shape() -> Arc<ToolShape> {
    let surface = vec![SurfacePoint { position: DVec3::ZERO, normal: DVec3::Z }];
    Arc::new(ToolShape::from(vec![Part { solid: Solid::Cuboid { half: DVec3::splat(0.01) }, surface }]))
}
