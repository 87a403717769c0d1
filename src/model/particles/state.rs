//! What a particle model carries from step to step.
use crate::graph::{GraphPolicy, Skeleton};
use crate::model::order::Order;
use crate::state::{Constants, Control, Particles, ParticlesGrad, Pose, PoseGrad, Scene, ToolShape, Wall};
use glam::DVec3;
use std::sync::Arc;

/// Particles in canonical order, and the tool.
#[derive(Clone, Debug)]
pub struct ParticleState {
    /// Particles now, in canonical order.
    pub(super) particles: Particles,
    /// Velocities one, two … control steps before, in canonical order: as many as the model remembers.
    pub(super) past: Vec<Vec<DVec3>>,
    /// Where the scene has each canonical row.
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
    /// Pose of each part now.
    pub(super) poses: Vec<Pose>,
    /// Duration of one control step \[s\].
    pub(super) interval: f64,
}

impl ParticleState {
    /// Of a scene whose bodies of these numbers are `rigid`, with the skeleton that `graph` draws over it and `memory` velocities of the
    /// past, zero where the scene knows none.
    pub(super) fn new(scene: &Scene, graph: Option<&dyn GraphPolicy>, rigid: &[u32], memory: usize) -> Self {
        let order = Order::of(scene);
        let body: Arc<[u32]> = order.gather(&scene.body).into();
        let rows = |number: &u32| (0..body.len()).filter(|&i| body[i] == *number).map(|i| i as u32).collect();
        let rigid: Vec<Vec<u32>> = rigid.iter().map(rows).filter(|rows: &Vec<u32>| !rows.is_empty()).collect();
        let mut past: Vec<Vec<DVec3>> = scene.past.iter().take(memory).map(|rows| order.gather(rows)).collect();
        past.resize(memory, vec![DVec3::ZERO; body.len()]);
        let Particles { positions, velocities } = &scene.particles;
        let particles = Particles { positions: order.gather(positions), velocities: order.gather(velocities) };
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
            poses: scene.poses.clone(),
            interval: scene.interval,
        }
    }

    /// The state after a step that ends with these particles.
    pub(super) fn next(&self, particles: Particles, control: &Control) -> Self {
        let past = std::iter::once(&self.particles.velocities).chain(&self.past).take(self.past.len());
        Self {
            particles,
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

/// `∂J/∂state`, flat as `[positions 3N | velocities 3N | past 3N each | poses 6 per part: translation, rotation]`.
#[derive(Clone, Debug)]
pub(super) struct StateGrad {
    pub(super) particles: ParticlesGrad,
    pub(super) past: Vec<Vec<DVec3>>,
    pub(super) poses: Vec<PoseGrad>,
}

impl StateGrad {
    /// Reads the flat layout for `state`.
    pub(super) fn read(flat: &[f64], state: &ParticleState) -> Self {
        let count = state.particles.len();
        let rows: Vec<DVec3> = flat.chunks_exact(3).map(DVec3::from_slice).collect();
        let (positions, rest) = rows.split_at(count);
        let (velocities, rest) = rest.split_at(count);
        let (past, poses) = rest.split_at(count * state.past.len());
        Self {
            past: (0..state.past.len()).map(|k| past[k * count..(k + 1) * count].to_vec()).collect(),
            particles: ParticlesGrad { positions: positions.to_vec(), velocities: velocities.to_vec() },
            poses: poses.chunks_exact(2).map(|p| PoseGrad { translation: p[0], rotation: p[1] }).collect(),
        }
    }

    /// Writes the flat layout.
    pub(super) fn flat(&self) -> Vec<f64> {
        let poses = self.poses.iter().flat_map(|p| [p.translation, p.rotation]);
        let ParticlesGrad { positions, velocities } = &self.particles;
        let rows = positions.iter().chain(velocities).chain(self.past.iter().flatten()).copied().chain(poses);
        rows.flat_map(|v| v.to_array()).collect()
    }
}
