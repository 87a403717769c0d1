//! The border between metres and the engine's units: lengths grow, time stays.
use crate::state::Pose;
use glam::DVec3;
use rapier3d::math::{Pose as EnginePose, Real, Rotation, Vector};

/// Engine lengths per metre. The engine's tolerances suit objects of about a metre; dough a few centimetres wide, simulated
/// at true size, leaked through the table.
pub(super) const LENGTH: f64 = 20.0;

/// Standard gravity \[m/s²\].
pub(super) const GRAVITY: f64 = 9.81;

/// A length \[m\] in engine units.
pub(super) fn length(metres: f64) -> Real {
    (metres * LENGTH) as Real
}

/// A point or displacement \[m\] in engine units.
pub(super) fn inward(point: DVec3) -> Vector {
    (point * LENGTH).as_vec3()
}

/// A point or displacement of the engine \[m\].
pub(super) fn outward(point: Vector) -> DVec3 {
    point.as_dvec3() / LENGTH
}

/// A rigid pose in engine units.
pub(super) fn pose(pose: &Pose) -> EnginePose {
    let r = pose.rotation;
    let rotation = Rotation::from_xyzw(r.x as Real, r.y as Real, r.z as Real, r.w as Real).normalize();
    EnginePose::from_parts(inward(pose.translation), rotation)
}
