//! What a particle model carries from step to step.
use crate::graph::{GraphPolicy, Skeleton};
use crate::state::{Constants, Control, Particles, ParticlesGrad, Pose, PoseGrad, Scene, ToolShape, Wall};
use glam::DVec3;
use std::sync::Arc;

/// Particles in canonical order, and the tool.
///
/// The order is lexicographic in position, then velocity, then body, at the start: sums over neighbours then run in an order that does not
/// know how the scene numbered its particles, so relabelling them relabels the prediction bit for bit.
#[derive(Clone, Debug)]
pub struct ParticleState {
    /// Particles now, in canonical order.
    pub(super) particles: Particles,
    /// Velocities one, two … control steps before, in canonical order: as many as the model remembers.
    pub(super) past: Vec<Vec<DVec3>>,
    /// Row of the scene that each canonical row came from.
    order: Arc<[u32]>,
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
        let particles = &scene.particles;
        let key = |i: u32| {
            let (x, v) = (particles.positions[i as usize], particles.velocities[i as usize]);
            [x.x, x.y, x.z, v.x, v.y, v.z]
        };
        let mut order: Vec<u32> = (0..particles.len() as u32).collect();
        order.sort_by(|&a, &b| {
            let pairs = key(a).into_iter().zip(key(b));
            let differ = pairs.map(|(a, b)| a.total_cmp(&b)).find(|o| o.is_ne());
            differ.unwrap_or_else(|| scene.body[a as usize].cmp(&scene.body[b as usize]))
        });
        let body: Arc<[u32]> = order.iter().map(|&i| scene.body[i as usize]).collect();
        let rows = |number: &u32| (0..body.len()).filter(|&i| body[i] == *number).map(|i| i as u32).collect();
        let rigid: Vec<Vec<u32>> = rigid.iter().map(rows).filter(|rows: &Vec<u32>| !rows.is_empty()).collect();
        let sorted = |rows: &[DVec3]| order.iter().map(|&i| rows[i as usize]).collect();
        let mut past: Vec<Vec<DVec3>> = scene.past.iter().take(memory).map(|rows| sorted(rows)).collect();
        past.resize(memory, vec![DVec3::ZERO; order.len()]);
        let particles =
            Particles { positions: sorted(&particles.positions), velocities: sorted(&particles.velocities) };
        Self {
            skeleton: Arc::new(graph.map(|graph| graph.skeleton(&particles, &body)).unwrap_or_default()),
            particles,
            past,
            order: order.into(),
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
            order: Arc::clone(&self.order),
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
            positions: self.scatter(&self.particles.positions),
            velocities: self.scatter(&self.particles.velocities),
        }
    }

    /// Canonical rows into the scene's order.
    pub(super) fn scatter(&self, rows: &[DVec3]) -> Vec<DVec3> {
        let mut out = vec![DVec3::ZERO; rows.len()];
        for (row, &i) in rows.iter().zip(self.order.iter()) {
            out[i as usize] = *row;
        }
        out
    }

    /// Rows of the scene into canonical order.
    pub(super) fn gather(&self, rows: &[DVec3]) -> Vec<DVec3> {
        self.order.iter().map(|&i| rows[i as usize]).collect()
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
