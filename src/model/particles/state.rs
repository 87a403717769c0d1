//! What a particle model carries from step to step.
use crate::graph::{GraphPolicy, Skeleton};
use crate::model::law::History;
use crate::state::{Constants, Control, Order, Particles, Pose, Scene, ToolShape, Wall};
use glam::DVec3;
use std::sync::Arc;

/// Particles in canonical order, see [`Order`], and the tool.
#[derive(Clone, Debug)]
pub struct ParticleState {
    /// Particles now, in canonical order.
    pub(super) particles: Particles,
    /// Velocities one, two … control steps before, in canonical order: as many as the model remembers.
    pub(super) past: Vec<Vec<DVec3>>,
    /// Row of the scene that each canonical row came from.
    pub(super) order: Order,
    /// Number of the body that each belongs to, in canonical order.
    pub(super) body: Arc<[u32]>,
    /// Rows of each body that keeps its shape.
    pub(super) rigid: Arc<[Vec<u32>]>,
    /// Walls around the table.
    pub(super) walls: Arc<[Wall]>,
    /// Constants of the materials.
    pub(super) constants: Arc<Constants>,
    /// Tool geometry.
    pub(super) tool: Arc<ToolShape>,
    /// What the model's graph keeps from the start.
    pub(super) skeleton: Arc<Skeleton>,
    /// What each law remembers of pairs, in the order of the model's laws.
    pub(super) histories: Vec<History>,
    /// Pose of each part now.
    pub(super) poses: Vec<Pose>,
    /// Duration of one control step \[s\].
    pub(super) interval: f64,
}

impl ParticleState {
    /// Of a scene whose bodies of these numbers are `rigid`, with the skeleton that `graph` draws over it and `memory` velocities of the
    /// past, zero where the scene knows none.
    pub(super) fn new(scene: &Scene, graph: Option<&dyn GraphPolicy>, rigid: &[u32], memory: usize) -> Self {
        let particles = &scene.particles;
        let order = Order::of(scene);
        let body: Arc<[u32]> = order.gather(&scene.body).into();
        let rows = |number: &u32| (0..body.len()).filter(|&i| body[i] == *number).map(|i| i as u32).collect();
        let rigid: Vec<Vec<u32>> = rigid.iter().map(rows).filter(|rows: &Vec<u32>| !rows.is_empty()).collect();
        let mut past: Vec<Vec<DVec3>> = scene.past.iter().take(memory).map(|rows| order.gather(rows)).collect();
        past.resize(memory, vec![DVec3::ZERO; body.len()]);
        let particles = Particles {
            positions: order.gather(&particles.positions),
            velocities: order.gather(&particles.velocities),
        };
        Self {
            skeleton: Arc::new(graph.map(|graph| graph.skeleton(&particles, &body)).unwrap_or_default()),
            particles,
            past,
            order,
            body,
            rigid: rigid.into(),
            walls: Arc::clone(&scene.walls),
            constants: Arc::clone(&scene.constants),
            tool: Arc::clone(&scene.tool),
            histories: Vec::new(),
            poses: scene.poses.clone(),
            interval: scene.interval,
        }
    }

    /// The state after a step that ends with these particles and memories.
    pub(super) fn next(&self, particles: Particles, histories: Vec<History>, control: &Control) -> Self {
        let past = std::iter::once(&self.particles.velocities).chain(&self.past).take(self.past.len());
        Self {
            particles,
            histories,
            past: past.cloned().collect(),
            order: self.order.clone(),
            body: Arc::clone(&self.body),
            rigid: Arc::clone(&self.rigid),
            walls: Arc::clone(&self.walls),
            constants: Arc::clone(&self.constants),
            tool: Arc::clone(&self.tool),
            skeleton: Arc::clone(&self.skeleton),
            poses: control.poses.clone(),
            interval: self.interval,
        }
    }

    /// The particles in the scene's order.
    pub(super) fn decode(&self) -> Particles {
        Particles {
            positions: self.order.scatter(&self.particles.positions),
            velocities: self.order.scatter(&self.particles.velocities),
        }
    }
}
