//! The nodes of a graph: object particles, their roots, samples of the tool's surface, walls, and the floor.
use super::{CellList, EdgeSet, Roots, Skeleton};
use crate::state::{Particles, Pose, ToolShape, Wall};
use glam::DVec3;
use std::ops::Range;
use std::sync::Arc;

/// Rows `[particles | roots | tool surface samples | walls | floor]`; particles and roots receive.
#[derive(Clone, Debug, Default)]
pub struct Nodes {
    /// Number of particles N, the first rows.
    pub particles: usize,
    /// What the rollout keeps; each root is at the mean of its particles and has their mean velocity.
    pub skeleton: Arc<Skeleton>,
    /// The walls and, last, the floor.
    pub planes: Vec<Wall>,
    /// Positions \[m\]; rows of walls and of the floor are zero, their place is the receiver's projection.
    pub positions: Vec<DVec3>,
    /// Velocities \[m/s\]; a tool sample's is that of its part's twist at the end pose, `linear + angular × (p − t)`.
    pub velocities: Vec<DVec3>,
    /// Outward unit normals; zero for particles and roots.
    pub normals: Vec<DVec3>,
    /// Which tool part a row belongs to; empty rows are particles, roots, walls and floor.
    pub parts: Vec<Option<u32>>,
}

impl Nodes {
    /// Gathers the nodes of a scene at one instant, the tool moving from `before` to `poses` in `interval` seconds.
    pub fn gather(
        particles: &Particles,
        skeleton: &Arc<Skeleton>,
        walls: &[Wall],
        tool: &ToolShape,
        before: &[Pose],
        poses: &[Pose],
        interval: f64,
    ) -> Self {
        let roots = &skeleton.roots;
        let receivers = particles.len() + roots.len();
        let mut nodes = Self {
            particles: particles.len(),
            skeleton: Arc::clone(skeleton),
            planes: walls.iter().copied().chain([Wall::FLOOR]).collect(),
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
        for plane in nodes.planes.clone() {
            nodes.push(DVec3::ZERO, DVec3::ZERO, plane.normal, None);
        }
        nodes
    }

    /// Number of rows that receive: particles and roots.
    pub fn receivers(&self) -> usize {
        self.particles + self.roots().len()
    }

    /// The roots over the particles.
    pub fn roots(&self) -> &Roots {
        &self.skeleton.roots
    }

    /// Rows of the tool's samples.
    pub fn tool(&self) -> Range<usize> {
        self.receivers()..self.len() - self.planes.len()
    }

    /// Rows of the walls and, last, of the floor.
    pub fn planes(&self) -> Range<usize> {
        self.tool().end..self.len()
    }

    /// From row j to the receiver in row i \[m\]; from a plane at a right angle.
    pub fn offset(&self, i: usize, j: usize) -> DVec3 {
        match j.checked_sub(self.planes().start) {
            Some(plane) => self.planes[plane].offset_to(self.positions[i]),
            None => self.positions[i] - self.positions[j],
        }
    }

    /// Edges into every particle from all particles, itself too, roots and tool samples strictly within `radius` \[m\].
    pub fn near(&self, radius: f64) -> EdgeSet {
        let cells = CellList::new(&self.positions[..self.tool().end], radius);
        cells.neighbours(&self.positions[..self.particles], radius)
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
