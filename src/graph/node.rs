//! The nodes of a graph: object particles, their roots, samples of the tool's surface, and the floor.
use super::Roots;
use crate::state::{Particles, Pose, ToolShape};
use glam::DVec3;
use std::ops::Range;
use std::sync::Arc;

/// Rows `[particles | roots | tool surface samples | floor]`; particles and roots receive.
#[derive(Clone, Debug, Default)]
pub struct Nodes {
    /// Number of particles N, the first rows.
    pub particles: usize,
    /// The roots, each at the mean of its particles and with their mean velocity.
    pub roots: Arc<Roots>,
    /// Positions \[m\]; the floor's row is zero, its place is below each receiver.
    pub positions: Vec<DVec3>,
    /// Velocities \[m/s\]; a tool sample's is that of its part's twist at the end pose, `linear + angular × (p − t)`.
    pub velocities: Vec<DVec3>,
    /// Outward unit normals; zero for particles and roots.
    pub normals: Vec<DVec3>,
    /// Which tool part a row belongs to; empty rows are particles, roots and floor.
    pub parts: Vec<Option<u32>>,
}

impl Nodes {
    /// Gathers the nodes of a scene at one instant, the tool moving from `before` to `poses` in `interval` seconds.
    pub fn gather(
        particles: &Particles,
        roots: &Arc<Roots>,
        tool: &ToolShape,
        before: &[Pose],
        poses: &[Pose],
        interval: f64,
    ) -> Self {
        let receivers = particles.len() + roots.len();
        let mut nodes = Self {
            particles: particles.len(),
            roots: Arc::clone(roots),
            positions: roots.with_means(&particles.positions),
            velocities: roots.with_means(&particles.velocities),
            normals: vec![DVec3::ZERO; receivers],
            parts: vec![None; receivers],
        };
        for (k, ((part, from), to)) in tool.parts.iter().zip(before).zip(poses).enumerate() {
            let twist = from.twist_to(to, interval);
            for point in &part.surface {
                let arm = to.rotation * point.position;
                let velocity = twist.linear + twist.angular.cross(arm);
                nodes.push(arm + to.translation, velocity, to.rotation * point.normal, Some(k as u32));
            }
        }
        nodes.push(DVec3::ZERO, DVec3::ZERO, DVec3::Z, None);
        nodes
    }

    /// Number of rows that receive: particles and roots.
    pub fn receivers(&self) -> usize {
        self.particles + self.roots.len()
    }

    /// Rows of the tool's samples.
    pub fn tool(&self) -> Range<usize> {
        self.receivers()..self.floor()
    }

    /// Row of the floor.
    pub fn floor(&self) -> usize {
        self.positions.len() - 1
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    fn push(&mut self, position: DVec3, velocity: DVec3, normal: DVec3, part: Option<u32>) {
        self.positions.push(position);
        self.velocities.push(velocity);
        self.normals.push(normal);
        self.parts.push(part);
    }
}
