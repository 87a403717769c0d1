//! What the particles of a soft body touch.
use glam::DVec3;
use rapier3d::parry::bounding_volume::BoundingVolume;
use rapier3d::prelude::{ColliderSet, Real, RigidBodyHandle, RigidBodySet, SoftBody, Vector};

/// Particles closer to a surface than this many skins touch it: the engine lets them rest one skin away.
const REACH: Real = 1.3;

/// The unit normals, out of them, of the surfaces that each particle of `body` touches: those of the table and of the parts of
/// the tool in `hand`.
pub(super) fn contacts(
    body: &SoftBody,
    (bodies, colliders): (&RigidBodySet, &ColliderSet),
    hand: &[RigidBodyHandle],
) -> Vec<Vec<DVec3>> {
    let reach = REACH * body.particle_radius();
    let pieces: Vec<_> = hand.iter().flat_map(|&part| bodies[part].colliders()).map(|&c| &colliders[c]).collect();
    let boxes: Vec<_> = pieces.iter().map(|piece| piece.compute_aabb().loosened(reach)).collect();
    let touched = |p: Vector| {
        let table = (p.z < reach).then_some(Vector::Z);
        let near = pieces.iter().zip(&boxes).filter(|(_, around)| around.contains_local_point(p));
        let tool = near.filter_map(|(piece, _)| {
            let on = piece.shape().project_point(piece.position(), p, false);
            let away = if on.is_inside { on.point - p } else { p - on.point };
            (on.is_inside || away.length() < reach).then(|| away.normalize_or_zero())
        });
        table.into_iter().chain(tool.filter(|n| *n != Vector::ZERO)).map(|n| n.as_dvec3()).collect()
    };
    body.particle_positions().map(touched).collect()
}
