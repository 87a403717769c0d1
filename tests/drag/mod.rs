//! A smooth model whose derivatives are known, tools for it, and goals that they can reach.
#![allow(dead_code, reason = "each test file uses its own part")]
use glam::{DQuat, DVec3};
use pliant::metric::{CostSpec, GoalCost};
use pliant::model::{Adjoint, Dynamics, WorldModel};
use pliant::planner::{Planner, PlannerSpec};
use pliant::problem::Budget;
use pliant::state::*;
use pliant::tool::{Motion, Tool, Workpiece};
use rand::Rng;
use std::sync::Arc;

const WIDTH: f64 = 0.02;
/// The bump's middle in the tool's frame: away from its origin, so that turning moves it.
const TIP: DVec3 = DVec3::new(0.01, 0.0, 0.0);

/// Particles are carried along by a Gaussian bump around the tool's tip: `x' = x + exp(−|x − c|²/2σ²) (c' − c)`.
pub(crate) struct Drag;

#[derive(Clone)]
pub(crate) struct Dragged {
    positions: Vec<DVec3>,
    pose: Pose,
}

fn tip_pull(pose: &Pose, at_tip: DVec3) -> [f64; 6] {
    let turn = (pose.rotation * TIP).cross(at_tip);
    [at_tip.x, at_tip.y, at_tip.z, turn.x, turn.y, turn.z]
}

fn pose_grad(flat: &[f64]) -> PoseGrad {
    PoseGrad { translation: DVec3::from_slice(flat), rotation: DVec3::from_slice(&flat[3..]) }
}

impl Dynamics for Drag {
    type State = Dragged;

    fn accepts(&self, scene: &Scene) -> anyhow::Result<()> {
        anyhow::ensure!(scene.poses.len() == 1, "a drag has one part");
        Ok(())
    }
    fn encode(&self, scene: &Scene) -> Dragged {
        Dragged { positions: scene.particles.positions.clone(), pose: scene.poses[0] }
    }
    fn step(&self, state: &Dragged, control: &Control) -> Dragged {
        let (from, to) = (state.pose.apply(TIP), control.poses[0].apply(TIP));
        let carry = |x: &DVec3| *x + (-x.distance_squared(from) / (2.0 * WIDTH * WIDTH)).exp() * (to - from);
        Dragged { positions: state.positions.iter().map(carry).collect(), pose: control.poses[0] }
    }
    fn decode(&self, state: &Dragged) -> Particles {
        Particles::at_rest(state.positions.clone())
    }
    fn adjoint(&self) -> Option<&dyn Adjoint<Dragged>> {
        Some(self)
    }
}

impl Adjoint<Dragged> for Drag {
    fn step_vjp(&self, state: &Dragged, control: &Control, next: &[f64], _: &mut [f32]) -> (Vec<f64>, ControlGrad) {
        let (from, to) = (state.pose.apply(TIP), control.poses[0].apply(TIP));
        let (mut back, mut at_from, mut at_to) = (Vec::new(), DVec3::ZERO, DVec3::ZERO);
        for (x, pull) in state.positions.iter().zip(next.chunks(3)) {
            let (away, pull) = (*x - from, DVec3::from_slice(pull));
            let bump = (-away.length_squared() / (2.0 * WIDTH * WIDTH)).exp();
            let by_place = pull.dot(to - from) * -bump / (WIDTH * WIDTH) * away;
            back.extend((pull + by_place).to_array());
            at_from -= by_place + bump * pull;
            at_to += bump * pull;
        }
        back.extend(tip_pull(&state.pose, at_from));
        let mut control_grad = pose_grad(&tip_pull(&control.poses[0], at_to));
        let carried = pose_grad(&next[next.len() - 6..]);
        control_grad.translation += carried.translation;
        control_grad.rotation += carried.rotation;
        (back, ControlGrad { poses: vec![control_grad] })
    }
    fn decode_vjp(&self, _: &Dragged, particles: &ParticlesGrad) -> Vec<f64> {
        particles.positions.iter().flat_map(|p| p.to_array()).chain([0.0; 6]).collect()
    }
    fn encode_vjp(&self, start: &Dragged, at_start: &[f64], _: &mut [f32]) -> SceneGrad {
        let (places, pose) = at_start.split_at(3 * start.positions.len());
        let mut particles = ParticlesGrad::zero(start.positions.len());
        particles.positions.iter_mut().zip(places.chunks(3)).for_each(|(p, g)| *p = DVec3::from_slice(g));
        SceneGrad { particles, poses: vec![pose_grad(pose)] }
    }
}

/// The same motion without derivatives, and with a velocity that is not finite, which no cost looks at, while the tool is at x < 0.
pub(crate) struct Broken;

impl Dynamics for Broken {
    type State = Dragged;
    fn encode(&self, scene: &Scene) -> Dragged {
        Drag.encode(scene)
    }
    fn step(&self, state: &Dragged, control: &Control) -> Dragged {
        Drag.step(state, control)
    }
    fn decode(&self, state: &Dragged) -> Particles {
        let mut particles = Drag.decode(state);
        if state.pose.translation.x < 0.0 {
            particles.velocities[0].x = f64::NAN;
        }
        particles
    }
}

/// Starts at (x, y), turned by an angle, and slides `length` along its own x axis while it turns a little.
pub(crate) struct Slide {
    shape: Arc<ToolShape>,
    length: f64,
}

pub(crate) fn slide(length: f64) -> Slide {
    let solid = Solid::Cuboid { half: DVec3::splat(0.01) };
    Slide { shape: Arc::new(ToolShape::from(vec![Part { solid, surface: Vec::new() }])), length }
}

impl Tool for Slide {
    fn shape(&self) -> &Arc<ToolShape> {
        &self.shape
    }
    fn space(&self, piece: &Workpiece) -> ActionSpace {
        let names = ["x", "y", "rotation"].map(String::from).to_vec();
        let DVec3 { x, y, .. } = piece.extent;
        ActionSpace { names, low: vec![-x, -y, -3.0], high: vec![x, y, 3.0] }
    }
    fn motion(&self, theta: &[f64], piece: &Workpiece, steps: usize) -> Motion {
        let pose = |t: usize| {
            let s = t as f64 / steps as f64;
            let along = DVec3::new(theta[2].cos(), theta[2].sin(), 0.0);
            Pose {
                translation: piece.centre + DVec3::new(theta[0], theta[1], 0.005) + s * self.length * along,
                rotation: DQuat::from_rotation_z(theta[2] + 0.5 * s),
            }
        };
        let controls = (1..=steps).map(|t| Control { poses: vec![pose(t)] }).collect();
        Motion { start: vec![pose(0)], controls }
    }
}

fn cloud() -> Vec<DVec3> {
    let mut rng = stream(1, &[1]);
    (0..50)
        .map(|_| 0.06 * DVec3::new(rng.random::<f64>() - 0.5, rng.random::<f64>() - 0.5, rng.random::<f64>() / 6.0))
        .collect()
}

pub(crate) fn scene(shape: &Arc<ToolShape>, poses: &[Pose]) -> Scene {
    Scene::open(Particles::at_rest(cloud()), shape.clone(), poses.to_vec(), 0.1)
}

pub(crate) fn piece() -> Workpiece {
    Workpiece::around(&Particles::at_rest(cloud()))
}

/// The shape that a slide of `length` at `theta` leaves: reachable, but not by what planners try first.
pub(crate) fn goal(length: f64, theta: &[f64]) -> Vec<DVec3> {
    let tool = slide(length);
    let motion = tool.motion(theta, &piece(), 6);
    Drag.rollout(&scene(tool.shape(), &motion.start), &motion.controls).pop().unwrap().positions
}

pub(crate) fn cost(kind: &str, goal: Vec<DVec3>) -> GoalCost {
    let text = match kind {
        "weighted" => "kind = 'weighted'\nchamfer = 0.5\nemd = 0.5",
        "iou" => "kind = 'missed'\nof = { kind = 'iou', voxel = 0.01 }",
        _ => &format!("kind = '{kind}'"),
    };
    let spec: CostSpec = toml_edit::de::from_str(text).unwrap();
    GoalCost::new(spec.build().unwrap(), goal).unwrap()
}

pub(crate) fn planner(stem: &str) -> Box<dyn Planner> {
    let path = format!("{}/configs/planner/{stem}.toml", env!("CARGO_MANIFEST_DIR"));
    let spec: PlannerSpec = toml_edit::de::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    spec.build().unwrap()
}

pub(crate) const BUDGET: Budget = Budget { rollouts: 400, gradient_price: 3, seconds: None };
