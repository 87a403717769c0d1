//! What the material point method carries from step to step.
use super::real::{Matrix, Real, Vector};
use crate::state::{Control, Order, Particles, Pose, PoseGrad, Scene, ToolShape, Wall};
use glam::{DMat3, DVec3};
use std::sync::Arc;

/// Material points, or derivatives by them: N rows each.
///
/// Places stay in f64: away from the origin, a creeping point's way in a substep is less than f32 can add to its place.
#[derive(Clone, Debug)]
pub(super) struct Points<R: Real> {
    /// x \[m\].
    pub(super) positions: Vec<DVec3>,
    /// v \[m/s\].
    pub(super) velocities: Vec<R::Vector>,
    /// C, the velocity's gradient around a point \[1/s\].
    pub(super) affine: Vec<R::Matrix>,
    /// b, the elastic left Cauchy–Green tensor, symmetric \[1\].
    pub(super) strain: Vec<R::Matrix>,
}

impl<R: Real> Default for Points<R> {
    fn default() -> Self {
        Self { positions: Vec::new(), velocities: Vec::new(), affine: Vec::new(), strain: Vec::new() }
    }
}

impl<R: Real> Points<R> {
    /// The nearest in this precision.
    pub(super) fn of(points: &Points<f64>) -> Self {
        Self {
            positions: points.positions.clone(),
            velocities: points.velocities.iter().copied().map(R::Vector::of).collect(),
            affine: points.affine.iter().copied().map(R::Matrix::of).collect(),
            strain: points.strain.iter().copied().map(R::Matrix::of).collect(),
        }
    }

    pub(super) fn wide(self) -> Points<f64> {
        Points {
            positions: self.positions,
            velocities: self.velocities.into_iter().map(R::Vector::wide).collect(),
            affine: self.affine.into_iter().map(R::Matrix::wide).collect(),
            strain: self.strain.into_iter().map(R::Matrix::wide).collect(),
        }
    }

    /// Empty again, its memory kept.
    pub(super) fn clear(&mut self) {
        self.positions.clear();
        self.velocities.clear();
        self.affine.clear();
        self.strain.clear();
    }

    /// Adds the rows of `other`.
    pub(super) fn extend(&mut self, other: &Self) {
        self.positions.extend_from_slice(&other.positions);
        self.velocities.extend_from_slice(&other.velocities);
        self.affine.extend_from_slice(&other.affine);
        self.strain.extend_from_slice(&other.strain);
    }
}

/// Material points in canonical order, and the tool.
#[derive(Clone, Debug)]
pub struct MpmState {
    pub(super) points: Points<f64>,
    /// Where the scene has each row.
    pub(super) order: Order,
    /// Walls around the table.
    pub(super) walls: Arc<[Wall]>,
    /// Tool geometry.
    pub(super) tool: Arc<ToolShape>,
    /// Pose of each part now.
    pub(super) poses: Vec<Pose>,
    /// Duration of one control step \[s\].
    pub(super) interval: f64,
}

impl MpmState {
    /// Of a scene, at ease: without strain, each point moving as a whole.
    pub(super) fn new(scene: &Scene) -> Self {
        let order = Order::of(scene);
        let count = scene.particles.len();
        let points = Points {
            positions: order.gather(&scene.particles.positions),
            velocities: order.gather(&scene.particles.velocities),
            affine: vec![DMat3::ZERO; count],
            strain: vec![DMat3::IDENTITY; count],
        };
        Self {
            points,
            order,
            walls: Arc::clone(&scene.walls),
            tool: Arc::clone(&scene.tool),
            poses: scene.poses.clone(),
            interval: scene.interval,
        }
    }

    /// The state after a step that ends with these points.
    pub(super) fn next(&self, points: Points<f64>, control: &Control) -> Self {
        Self {
            points,
            order: self.order.clone(),
            walls: Arc::clone(&self.walls),
            tool: Arc::clone(&self.tool),
            poses: control.poses.clone(),
            interval: self.interval,
        }
    }

    /// The particles in the scene's order.
    pub(super) fn decode(&self) -> Particles {
        Particles {
            positions: self.order.scatter(&self.points.positions),
            velocities: self.order.scatter(&self.points.velocities),
        }
    }

    /// Linear momentum \[m/s\] and angular momentum about the origin \[m²/s\] per particle's mass: `Σ v` and
    /// `Σ x × v + Δ²/4 ε : Cᵀ`, the spin of a particle's affine motion included (Jiang et al. 2015, section 5.3), on cells of Δ
    /// \[m\].
    pub fn momentum(&self, cell: f64) -> (DVec3, DVec3) {
        let Points { positions, velocities, affine, .. } = &self.points;
        let linear = velocities.iter().sum();
        let orbit: DVec3 = positions.iter().zip(velocities).map(|(x, v)| x.cross(*v)).sum();
        let axial = |c: &DMat3| DVec3::new(c.y_axis.z - c.z_axis.y, c.z_axis.x - c.x_axis.z, c.x_axis.y - c.y_axis.x);
        let spin: DVec3 = affine.iter().map(axial).sum();
        (linear, orbit + cell * cell / 4.0 * spin)
    }
}

/// `∂J/∂state`, flat as `[positions 3N | velocities 3N | affine 9N | strain 9N | poses 6 per part: translation, rotation]`,
/// matrices column by column.
pub(super) struct StateGrad {
    pub(super) points: Points<f64>,
    pub(super) poses: Vec<PoseGrad>,
}

impl StateGrad {
    /// Reads the flat layout for `count` particles.
    pub(super) fn read(flat: &[f64], count: usize) -> Self {
        let vectors = |from: usize| flat[from..from + 3 * count].chunks_exact(3).map(DVec3::from_slice).collect();
        let matrices = |from: usize| flat[from..from + 9 * count].chunks_exact(9).map(DMat3::from_cols_slice).collect();
        let points = Points {
            positions: vectors(0),
            velocities: vectors(3 * count),
            affine: matrices(6 * count),
            strain: matrices(15 * count),
        };
        let pose = |row: &[f64]| PoseGrad {
            translation: DVec3::from_slice(&row[..3]),
            rotation: DVec3::from_slice(&row[3..]),
        };
        Self { points, poses: flat[24 * count..].chunks_exact(6).map(pose).collect() }
    }

    /// Writes the flat layout.
    pub(super) fn flat(&self) -> Vec<f64> {
        let Points { positions, velocities, affine, strain } = &self.points;
        let mut flat = Vec::with_capacity(24 * positions.len() + 6 * self.poses.len());
        flat.extend(positions.iter().chain(velocities).flat_map(|v| v.to_array()));
        flat.extend(affine.iter().chain(strain).flat_map(|m| m.to_cols_array()));
        flat.extend(self.poses.iter().flat_map(|p| [p.translation, p.rotation]).flat_map(|v| v.to_array()));
        flat
    }
}
