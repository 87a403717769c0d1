//! Rigid assemblies: solids at fixed places in one frame, for tools that no single solid describes.
use super::{Pose, Projection, Solid, SurfacePoint};
use glam::{DMat3, DVec3};

/// One solid of an assembly, and where it sits.
#[derive(Clone, Debug)]
pub struct Placed {
    /// The piece.
    pub solid: Solid,
    /// From the piece's frame into the assembly's.
    pub pose: Pose,
}

impl Placed {
    fn project(&self, point: DVec3) -> Projection {
        let field = self.solid.project(self.pose.inverse_apply(point));
        let turn = DMat3::from_quat(self.pose.rotation);
        Projection {
            distance: field.distance,
            normal: turn * field.normal,
            curvature: turn * field.curvature * turn.transpose(),
        }
    }

    /// The farthest that the piece may reach along each axis from the assembly's origin \[m\].
    fn reach(&self) -> DVec3 {
        let half = self.solid.half_extents();
        let turn = DMat3::from_quat(self.pose.rotation);
        let turned = turn.x_axis.abs() * half.x + turn.y_axis.abs() * half.y + turn.z_axis.abs() * half.z;
        self.pose.translation.abs() + turned
    }
}

/// `d = minᵢ dᵢ`: exact outside, where the nearest piece is the nearest solid; inside, the depth in the piece that holds the point
/// deepest, a lower bound of the true depth.
pub(super) fn project(pieces: &[Placed], point: DVec3) -> Projection {
    let nearest = pieces.iter().map(|piece| piece.project(point)).min_by(|a, b| a.distance.total_cmp(&b.distance));
    nearest.expect("an assembly has at least one piece")
}

pub(super) fn half_extents(pieces: &[Placed]) -> DVec3 {
    pieces.iter().fold(DVec3::ZERO, |reach, piece| reach.max(piece.reach()))
}

/// The pieces' samples without those that another piece covers; of two faces in one place the first piece's is kept.
pub(super) fn surface(pieces: &[Placed], spacing: f64) -> Vec<SurfacePoint> {
    const TOUCH: f64 = 1e-9;
    let mut points = Vec::new();
    for (i, piece) in pieces.iter().enumerate() {
        let place = |p: SurfacePoint| SurfacePoint {
            position: piece.pose.apply(p.position),
            normal: piece.pose.rotation * p.normal,
        };
        let covered = |p: &SurfacePoint| {
            pieces.iter().enumerate().filter(|(j, _)| *j != i).any(|(j, other)| {
                let field = other.project(p.position);
                let shared = field.distance <= TOUCH && (field.normal.dot(p.normal) < 0.0 || j < i);
                field.distance < -TOUCH || shared
            })
        };
        points.extend(piece.solid.surface(spacing).into_iter().map(place).filter(|p| !covered(p)));
    }
    points
}
