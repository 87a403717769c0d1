//! The tool in hand: kinematic rigid bodies in the shape of its parts.
use super::scale::{inward, length, pose};
use crate::state::{Pose, Solid, ToolShape, TriangleMesh};
use rapier3d::prelude::*;

/// How much of its convex hull a mesh must fill to collide as that hull.
const CONVEX: f64 = 0.95;

/// Puts the parts of `tool` into the world at `poses`.
pub(super) fn hold(
    physics: &mut PhysicsWorld,
    tool: &ToolShape,
    poses: &[Pose],
    friction: Real,
) -> Vec<RigidBodyHandle> {
    tool.parts
        .iter()
        .zip(poses)
        .map(|(part, at)| {
            let body = RigidBodyBuilder::kinematic_position_based().pose(pose(at)).can_sleep(false);
            physics.insert(body, collider(&part.solid).friction(friction)).0
        })
        .collect()
}

/// Takes the bodies out of the world again.
pub(super) fn release(physics: &mut PhysicsWorld, hand: &[RigidBodyHandle]) {
    for &body in hand {
        physics.remove_body(body);
    }
}

/// Tells each body where it will be after the next physics step.
pub(super) fn carry(physics: &mut PhysicsWorld, hand: &[RigidBodyHandle], poses: impl Iterator<Item = Pose>) {
    for (&body, to) in hand.iter().zip(poses) {
        physics.bodies[body].set_next_kinematic_position(pose(&to));
    }
}

fn collider(solid: &Solid) -> ColliderBuilder {
    match solid {
        Solid::Cuboid { half } => ColliderBuilder::cuboid(length(half.x), length(half.y), length(half.z)),
        Solid::Cylinder { radius, half_length } => ColliderBuilder::cylinder(length(*half_length), length(*radius)),
        Solid::Mesh(mesh) => mesh_collider(mesh),
    }
}

/// A convex solid pushes out whatever is inside it, a triangle mesh only what crosses its surface: so the hull wherever the
/// mesh is nearly convex, or has no surface that the engine accepts.
fn mesh_collider(mesh: &TriangleMesh) -> ColliderBuilder {
    let points: Vec<Vector> = mesh.vertices.iter().map(|&v| inward(v)).collect();
    let hull = SharedShape::convex_hull(&points);
    let fills = |hull: &SharedShape| {
        let scale = f64::from(length(1.0)).powi(3);
        mesh_volume(mesh) >= CONVEX * f64::from(hull.mass_properties(1.0).mass()) / scale
    };
    let surface = || {
        SharedShape::trimesh_with_flags(points.clone(), mesh.triangles.clone(), TriMeshFlags::FIX_INTERNAL_EDGES).ok()
    };
    let shape = match hull {
        Some(hull) if fills(&hull) => hull,
        hull => surface().or(hull).unwrap_or_else(|| SharedShape::ball(length(mesh_radius(mesh)))),
    };
    ColliderBuilder::new(shape)
}

fn mesh_volume(mesh: &TriangleMesh) -> f64 {
    let corner = |i: u32| mesh.vertices[i as usize];
    mesh.triangles.iter().map(|t| corner(t[0]).dot(corner(t[1]).cross(corner(t[2]))) / 6.0).sum()
}

fn mesh_radius(mesh: &TriangleMesh) -> f64 {
    mesh.vertices.iter().map(|v| v.length()).fold(0.0, f64::max)
}
