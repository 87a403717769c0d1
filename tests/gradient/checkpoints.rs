//! Gradients that keep few states: the same bits, from a square root of the memory.
use super::constants::config;
use super::*;
use pliant::model::{Adjoint, Checkpoints, Dynamics, Gradient};
use pliant::state::{ControlGrad, ParticlesGrad, SceneGrad};
use serde_json::json;
use std::sync::atomic::{AtomicUsize, Ordering};

#[test]
fn a_gradient_of_few_kept_states_is_the_same_bit_for_bit() {
    let (scene, controls, cost) = problem(&mut ChaCha8Rng::seed_from_u64(7));
    for name in ["analytic", "bonds", "mpm"] {
        let mut config = config(name);
        let of = |config: &serde_json::Value, truncation: usize| {
            let model = constants::build(config);
            let gradient = model.gradient(&scene, &controls, &cost).unwrap();
            let by = model.constant_gradient(&scene, &controls, &cost, truncation);
            (gradient.cost, gradient.scene, gradient.controls, by)
        };
        let every = [STEPS, 2].map(|truncation| format!("{:?}", of(&config, truncation)));
        config["checkpoints"] = json!("root");
        let root = [STEPS, 2].map(|truncation| format!("{:?}", of(&config, truncation)));
        assert!(every == root, "{name}: another gradient");
        // The material point method has no constants, and so nothing that is truncated.
        assert!(root[0] != root[1] || name == "mpm", "{name}: truncation does nothing");
    }
}

#[test]
fn a_traced_step_gives_the_derivatives_of_one_computed_again() {
    let (scene, controls, cost) = problem(&mut ChaCha8Rng::seed_from_u64(7));
    for precision in ["single", "bfloat16"] {
        let mut config = config("learned");
        config["laws"][0]["precision"] = json!(precision);
        let of = |config: &serde_json::Value| {
            let mut model = constants::build(config);
            let loud: Vec<f32> = (0..).map(|i| (i as f32 * 0.7).sin() * 0.1).take(model.weights().len()).collect();
            model.set_weights(&loud);
            let told = |found: Option<Gradient>| {
                let Gradient { cost, scene, controls, weights } = found.unwrap();
                assert!(controls.iter().any(|at| at.poses[0].translation.length() > 1e-9), "nothing moves");
                (format!("{cost:?} {scene:?} {controls:?}"), weights)
            };
            (told(model.gradient(&scene, &controls, &cost)), told(model.weight_gradient(&scene, &controls, &cost)))
        };
        // With one state kept in a few, the last step before each is computed again; a rounded model's states are rounded then, which
        // they are not where weights' derivatives were traced.
        let every = of(&config);
        config["checkpoints"] = json!("root");
        assert!(every.0 == of(&config).0, "{precision}: another gradient of a plan");
        assert!(precision == "bfloat16" || every.1 == of(&config).1, "{precision}: another gradient of weights");
    }
}

static ALIVE: AtomicUsize = AtomicUsize::new(0);
static MOST: AtomicUsize = AtomicUsize::new(0);

/// Positions that double a small bend in every step, and know how many of them there are.
struct Counted(Particles);

impl Counted {
    fn new(particles: Particles) -> Self {
        MOST.fetch_max(ALIVE.fetch_add(1, Ordering::SeqCst) + 1, Ordering::SeqCst);
        Self(particles)
    }
}

impl Clone for Counted {
    fn clone(&self) -> Self {
        Self::new(self.0.clone())
    }
}

impl Drop for Counted {
    fn drop(&mut self) {
        ALIVE.fetch_sub(1, Ordering::SeqCst);
    }
}

/// `x ← x + sin(x)/50`, in every coordinate.
struct Bend(Checkpoints);

impl Dynamics for Bend {
    type State = Counted;
    fn encode(&self, scene: &Scene) -> Counted {
        Counted::new(scene.particles.clone())
    }
    fn step(&self, Counted(x): &Counted, _: &Control) -> Counted {
        let positions = x.positions.iter().map(|x| *x + 0.02 * DVec3::new(x.x.sin(), x.y.sin(), x.z.sin())).collect();
        Counted::new(Particles { positions, velocities: x.velocities.clone() })
    }
    fn decode(&self, Counted(x): &Counted) -> Particles {
        x.clone()
    }
    fn checkpoints(&self) -> Checkpoints {
        self.0
    }
    fn adjoint(&self) -> Option<&dyn Adjoint<Counted>> {
        Some(self)
    }
}

impl Adjoint<Counted> for Bend {
    fn step_vjp(&self, Counted(x): &Counted, _: &Control, next: &[f64], _: &mut [f32]) -> (Vec<f64>, ControlGrad) {
        let rows = x.positions.iter().flat_map(|x| x.to_array()).zip(next);
        (rows.map(|(x, at)| at * (1.0 + 0.02 * x.cos())).collect(), ControlGrad::default())
    }
    fn decode_vjp(&self, _: &Counted, particles: &ParticlesGrad) -> Vec<f64> {
        particles.positions.iter().flat_map(|x| x.to_array()).collect()
    }
    fn encode_vjp(&self, _: &Counted, at_start: &[f64], _: &mut [f32]) -> SceneGrad {
        let positions: Vec<DVec3> = at_start.chunks_exact(3).map(DVec3::from_slice).collect();
        let velocities = vec![DVec3::ZERO; positions.len()];
        SceneGrad { particles: ParticlesGrad { positions, velocities }, poses: Vec::new() }
    }
}

struct Last;

impl Cost for Last {
    fn at(&self, t: usize, horizon: usize, x: &Particles) -> f64 {
        if t == horizon { x.positions[0].element_sum() } else { 0.01 * x.positions[0].length_squared() }
    }
    fn gradient(&self, t: usize, horizon: usize, x: &Particles) -> ParticlesGrad {
        let by = if t == horizon { DVec3::ONE } else { 0.02 * x.positions[0] };
        ParticlesGrad { positions: vec![by], velocities: vec![DVec3::ZERO] }
    }
}

#[test]
fn the_states_kept_are_twice_the_root_of_the_steps() {
    let particles = Particles::at_rest(vec![DVec3::new(0.3, -0.2, 0.9)]);
    let scene = Scene::open(particles, Arc::new(ToolShape::from(Vec::new())), Vec::new(), 0.1);
    let peak = |checkpoints: Checkpoints, steps: usize| {
        MOST.store(ALIVE.load(Ordering::SeqCst), Ordering::SeqCst);
        let gradient = Bend(checkpoints).gradient(&scene, &vec![Control::default(); steps], &Last).unwrap();
        (MOST.load(Ordering::SeqCst), gradient.cost.to_bits(), format!("{:?}", gradient.scene))
    };
    for steps in [0, 1, 2, 8, 9, 24, 25, 399, 400, 1000] {
        let ((all, cost, scene), (few, same, scene_too)) =
            (peak(Checkpoints::Every, steps), peak(Checkpoints::Root, steps));
        assert_eq!((cost, scene), (same, scene_too), "{steps} steps");
        assert!(all > steps, "{all} states of {steps} steps");
        assert!(few as f64 <= 2.0 * ((steps + 1) as f64).sqrt() + 3.0, "{few} states of {steps} steps");
    }
    // The derivative of the end by the start is the product of the steps' slopes.
    let end = |x: f64| (0..30).fold(x, |x, _| x + 0.02 * x.sin());
    let rollout = Bend(Checkpoints::Root).rollout(&scene, &vec![Control::default(); 30]);
    assert!((rollout[30].positions[0].x - end(0.3)).abs() < 1e-14);
}
