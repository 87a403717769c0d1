//! Rigid solids: signed distance with exact first and second derivatives, and surface samples.
use super::{Placed, Pose, TriangleMesh, assembly};
use glam::{DMat3, DVec3};
use std::sync::Arc;

/// The geometry of a tool: rigid parts, each in its own frame.
#[derive(Clone, Debug)]
pub struct ToolShape {
    /// Its parts; none where nothing is done.
    pub parts: Vec<Part>,
    /// Whether its [blades](Solid::blades) part soft material.
    pub cuts: bool,
}

/// A blunt tool.
impl From<Vec<Part>> for ToolShape {
    fn from(parts: Vec<Part>) -> Self {
        Self { parts, cuts: false }
    }
}

impl ToolShape {
    /// The surface samples of all parts where `poses` has them \[m\].
    pub fn surface_at<'a>(&'a self, poses: &'a [Pose]) -> impl Iterator<Item = DVec3> + 'a {
        let parts = self.parts.iter().zip(poses);
        parts.flat_map(|(part, pose)| part.surface.iter().map(|point| pose.apply(point.position)))
    }
}

/// One rigid part: the solid that collides, and points on its surface that a graph can join.
#[derive(Clone, Debug)]
pub struct Part {
    /// What collides.
    pub solid: Solid,
    /// Samples of its surface, in the part's frame.
    pub surface: Vec<SurfacePoint>,
}

/// A point of a surface and its outward unit normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Position \[m\].
    pub position: DVec3,
    /// Outward unit normal.
    pub normal: DVec3,
}

/// A closed solid centred in its own frame.
#[derive(Clone, Debug)]
pub enum Solid {
    /// A box with half extents \[m\].
    Cuboid {
        /// Half extents \[m\].
        half: DVec3,
    },
    /// A cylinder along the local y axis.
    Cylinder {
        /// Radius \[m\].
        radius: f64,
        /// Half of its length \[m\].
        half_length: f64,
    },
    /// A triangle mesh.
    Mesh(Arc<TriangleMesh>),
    /// Several solids at fixed places, none of them an assembly.
    Assembly(Arc<[Placed]>),
}

/// The signed distance field at one point.
#[derive(Clone, Copy, Debug)]
pub struct Projection {
    /// d \[m\]: negative inside.
    pub distance: f64,
    /// ∇d, the outward unit normal.
    pub normal: DVec3,
    /// ∇²d \[1/m\], zero opposite a flat face.
    pub curvature: DMat3,
}

impl Solid {
    /// Signed distance, normal and curvature at `point` in the solid's frame (Quilez's exact distances).
    pub fn project(&self, point: DVec3) -> Projection {
        match self {
            Self::Cuboid { half } => cuboid(*half, point),
            Self::Cylinder { radius, half_length } => cylinder(*radius, *half_length, point),
            Self::Mesh(mesh) => mesh.project(point),
            Self::Assembly(pieces) => assembly::project(pieces, point),
        }
    }

    /// Half extents of the axis-aligned box around the frame's origin that holds the solid \[m\].
    pub fn half_extents(&self) -> DVec3 {
        match self {
            Self::Cuboid { half } => *half,
            Self::Cylinder { radius, half_length } => DVec3::new(*radius, *half_length, *radius),
            Self::Mesh(mesh) => mesh.vertices.iter().fold(DVec3::ZERO, |m, v| m.max(v.abs())),
            Self::Assembly(pieces) => assembly::half_extents(pieces),
        }
    }
}

/// The field around the nearest point when `free` projects onto the directions in which that point is free to follow.
pub(super) fn rounded(offset: DVec3, free: DMat3) -> Projection {
    let distance = offset.length();
    let normal = offset / distance;
    let outer = DMat3::from_cols(normal * normal.x, normal * normal.y, normal * normal.z);
    Projection { distance, normal, curvature: (free - outer) * distance.recip() }
}

pub(super) fn flat(distance: f64, normal: DVec3) -> Projection {
    Projection { distance, normal, curvature: DMat3::ZERO }
}

fn cuboid(half: DVec3, point: DVec3) -> Projection {
    let sign = DVec3::ONE.copysign(point);
    let excess = point.abs() - half;
    if excess.max_element() <= 0.0 {
        let axis = if excess.x >= excess.y.max(excess.z) {
            DVec3::X
        } else if excess.y >= excess.z {
            DVec3::Y
        } else {
            DVec3::Z
        };
        return flat(excess.max_element(), axis * sign);
    }
    let outside = excess.max(DVec3::ZERO);
    let free = DMat3::from_diagonal(DVec3::select(excess.cmpgt(DVec3::ZERO), DVec3::ONE, DVec3::ZERO));
    rounded(outside * sign, free)
}

fn cylinder(radius: f64, half_length: f64, point: DVec3) -> Projection {
    let flat_point = DVec3::new(point.x, 0.0, point.z);
    let axial = flat_point.length();
    let side = if axial > 0.0 { flat_point / axial } else { DVec3::X };
    let up = DVec3::Y.copysign(DVec3::splat(point.y)) * DVec3::Y;
    let (past_side, past_end) = (axial - radius, point.y.abs() - half_length);
    // Turning about the axis carries the nearest side point along: a curvature of 1/axial in that direction.
    let around = side.cross(DVec3::Y);
    let turning = DMat3::from_cols(around * around.x, around * around.y, around * around.z) * axial.max(1e-12).recip();
    if past_side <= 0.0 && past_end <= 0.0 || past_side.min(past_end) <= 0.0 {
        return if past_end > past_side {
            flat(past_end, up)
        } else {
            Projection { distance: past_side, normal: side, curvature: turning }
        };
    }
    let offset = past_side * side + past_end * up;
    let plane = DMat3::from_cols(side * side.x, side * side.y, side * side.z) + DMat3::from_diagonal(DVec3::Y);
    let mut field = rounded(offset, plane);
    field.curvature += turning * (past_side / field.distance);
    field
}
