//! Solids as triangles, to draw.
use crate::state::{Pose, Solid};
use glam::{DVec3, dvec3};
use std::f64::consts::TAU;

/// Vertices \[m\] in the solid's frame and counter-clockwise corners of each triangle.
pub(super) type Facets = (Vec<DVec3>, Vec<[u32; 3]>);

/// Sides of the prism that a cylinder is drawn as.
const SIDES: u32 = 48;

/// The boundary of `solid`: exact but for cylinders, which are drawn as prisms inside them; the pieces of an assembly stay whole
/// where they overlap.
pub(super) fn facets(solid: &Solid) -> Facets {
    match solid {
        Solid::Cuboid { half } => cuboid(*half),
        Solid::Cylinder { radius, half_length } => cylinder(*radius, *half_length),
        Solid::Mesh(mesh) => (mesh.vertices.clone(), mesh.triangles.clone()),
        Solid::Assembly(pieces) => {
            let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
            for piece in pieces.iter() {
                append(facets(&piece.solid), &piece.pose, &mut vertices, &mut triangles);
            }
            (vertices, triangles)
        }
    }
}

fn append(piece: Facets, pose: &Pose, vertices: &mut Vec<DVec3>, triangles: &mut Vec<[u32; 3]>) {
    let first = vertices.len() as u32;
    vertices.extend(piece.0.into_iter().map(|v| pose.apply(v)));
    triangles.extend(piece.1.into_iter().map(|t| t.map(|v| v + first)));
}

fn cuboid(half: DVec3) -> Facets {
    let sign = |bit: u32, corner: u32| if corner & bit == 0 { -1.0 } else { 1.0 };
    let corners = (0..8).map(|c| half * dvec3(sign(1, c), sign(2, c), sign(4, c))).collect();
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    (corners, sides.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect())
}

fn cylinder(radius: f64, half_length: f64) -> Facets {
    let rim = |y: f64| {
        (0..SIDES).map(move |i| {
            let (sine, cosine) = (TAU * f64::from(i) / f64::from(SIDES)).sin_cos();
            dvec3(radius * cosine, y, radius * sine)
        })
    };
    let centres = [-half_length, half_length].map(|y| y * DVec3::Y);
    let vertices = rim(-half_length).chain(rim(half_length)).chain(centres).collect();
    let side = |i: u32| {
        let j = (i + 1) % SIDES;
        let (low, high) = (2 * SIDES, 2 * SIDES + 1);
        [[i, i + SIDES, j], [j, i + SIDES, j + SIDES], [low, i, j], [high, j + SIDES, i + SIDES]]
    };
    (vertices, (0..SIDES).flat_map(side).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::state::{Closure, Placed, TriangleMesh};
    use std::f64::consts::PI;

    /// The volume that the facets enclose when they close without being turned.
    fn volume(solid: &Solid) -> f64 {
        let (vertices, triangles) = facets(solid);
        let outward = triangles.iter().map(|t| t.map(|v| vertices[v as usize]));
        let signed: f64 = outward.map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum();
        let mesh = TriangleMesh::new(vertices, triangles).unwrap();
        assert_eq!(mesh.closure, Closure::Watertight);
        assert!((signed - mesh.volume()).abs() <= 1e-12 * signed.abs(), "some triangles face inward");
        signed
    }

    #[test]
    fn facets_close_face_outward_and_enclose_the_solid() {
        let cuboid = Solid::Cuboid { half: dvec3(0.1, 0.2, 0.3) };
        assert!((volume(&cuboid) - 0.048).abs() < 1e-12);
        let cylinder = Solid::Cylinder { radius: 0.1, half_length: 0.2 };
        let true_volume = PI * 0.01 * 0.4;
        let missing = 1.0 - volume(&cylinder) / true_volume;
        // A regular n-gon lacks 1 − sin(τ/n)/(τ/n) of its circle.
        let angle = TAU / f64::from(SIDES);
        assert!((missing - (1.0 - angle.sin() / angle)).abs() < 1e-12, "{missing}");
        let pose = Pose { translation: DVec3::X, rotation: glam::DQuat::from_rotation_z(0.3) };
        let pieces = vec![Placed { solid: cuboid, pose: Pose::default() }, Placed { solid: cylinder, pose }];
        let whole = volume(&Solid::Assembly(pieces.into()));
        assert!((whole - 0.048 - (1.0 - missing) * true_volume).abs() < 1e-12, "{whole}");
    }
}
