//! The tool in hand: kinematic rigid bodies in the shape of its parts.
use super::scale::{inward, length, pose};
use crate::state::{Blade, Pose, Solid, ToolShape, TriangleMesh};
use rapier3d::prelude::*;
use serde::{Deserialize, Serialize};

/// How much of its convex hull a mesh must fill to collide as that hull.
const CONVEX: f64 = 0.95;

/// The tool's parts in the engine, and what of them cuts.
#[derive(Clone, Default, Serialize, Deserialize)]
pub(super) struct Hand {
    /// One kinematic body a part.
    pub(super) parts: Vec<RigidBodyHandle>,
    /// What cuts, each with the number of the part that carries it.
    pub(super) blades: Vec<(u32, Blade)>,
}

impl Hand {
    /// Puts the parts of `tool` into the world at `poses`.
    pub(super) fn hold(physics: &mut PhysicsWorld, tool: &ToolShape, poses: &[Pose], friction: Real) -> Self {
        let mut hand = Self::default();
        for (k, (part, at)) in tool.parts.iter().zip(poses).enumerate() {
            let body = RigidBodyBuilder::kinematic_position_based().pose(pose(at)).can_sleep(false);
            let body = physics.insert_body(body);
            match &part.solid {
                Solid::Assembly(pieces) => pieces.iter().for_each(|piece| {
                    let collider = collider(&piece.solid).position(pose(&piece.pose)).friction(friction);
                    physics.insert_collider(collider, Some(body));
                }),
                single => {
                    physics.insert_collider(collider(single).friction(friction), Some(body));
                }
            }
            hand.parts.push(body);
            let blades = part.solid.blades().filter(|_| tool.cuts).unwrap_or_default();
            hand.blades.extend(blades.into_iter().map(|blade| (k as u32, blade)));
        }
        hand
    }

    /// Takes the bodies out of the world again.
    pub(super) fn release(&self, physics: &mut PhysicsWorld) {
        for &body in &self.parts {
            physics.remove_body(body);
        }
    }

    /// Tells each body where it will be after the next physics step.
    pub(super) fn carry(&self, physics: &mut PhysicsWorld, poses: &[Pose]) {
        for (&body, to) in self.parts.iter().zip(poses) {
            physics.bodies[body].set_next_kinematic_position(pose(to));
        }
    }
}

fn collider(solid: &Solid) -> ColliderBuilder {
    match solid {
        Solid::Cuboid { half } => ColliderBuilder::cuboid(length(half.x), length(half.y), length(half.z)),
        Solid::Cylinder { radius, half_length } => ColliderBuilder::cylinder(length(*half_length), length(*radius)),
        Solid::Mesh(mesh) => mesh_collider(mesh),
        Solid::Assembly(_) => unreachable!("the pieces of an assembly are no assemblies"),
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::state::Part;
    use crate::tool::SolidSpec;
    use glam::{DQuat, DVec3};
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn what_collides_is_where_the_signed_distance_says() {
        let solids = [
            SolidSpec::Cuboid { half: [0.02, 0.01, 0.03] },
            SolidSpec::Cylinder { radius: 0.02, half_length: 0.035 },
            SolidSpec::Tube { radius: 0.02, wall: 0.003, half_height: 0.03, sides: 12 },
        ];
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let rotation = DQuat::from_scaled_axis(DVec3::new(0.4, -0.2, 0.9));
        let at = Pose { translation: DVec3::new(0.01, 0.02, 0.1), rotation };
        for spec in solids {
            let solid = spec.build().unwrap();
            let tool = ToolShape::from(vec![Part { solid: solid.clone(), surface: Vec::new() }]);
            let mut physics = PhysicsWorld::new();
            let body = Hand::hold(&mut physics, &tool, &[at], 0.5).parts[0];
            for _ in 0..2000 {
                let point = at.translation + DVec3::from_array(std::array::from_fn(|_| rng.random_range(-0.06..0.06)));
                let colliders = physics.bodies[body].colliders().iter().map(|&c| &physics.colliders[c]);
                let near = colliders.map(|c| c.shape().distance_to_point(c.position(), inward(point), true));
                let collides = f64::from(near.fold(Real::INFINITY, Real::min)) / f64::from(length(1.0));
                let said = solid.project(at.inverse_apply(point)).distance.max(0.0);
                assert!((collides - said).abs() < 1e-6, "{solid:?}: {collides} against {said} at {point}");
            }
        }
    }
}
