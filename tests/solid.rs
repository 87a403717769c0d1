//! Signed distances: their derivatives, their values against brute force, and meshes against closed forms.
use glam::{DMat3, DQuat, DVec3};
use pliant::state::{Closure, Placed, Pose, Solid, TriangleMesh};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

fn mesh(vertices: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> TriangleMesh {
    TriangleMesh::new(vertices, triangles).unwrap()
}

/// A polygon (counter-clockwise, cut into a fan of `ears`) extruded from z = −height/2 to height/2.
fn prism(outline: &[(f64, f64)], ears: &[[u32; 3]], height: f64) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let n = outline.len() as u32;
    let ring = |z: f64| outline.iter().map(move |&(x, y)| DVec3::new(x, y, z));
    let vertices = ring(-height / 2.0).chain(ring(height / 2.0)).collect();
    let mut triangles: Vec<_> = ears.iter().flat_map(|&[a, b, c]| [[a, c, b], [a + n, b + n, c + n]]).collect();
    for i in 0..n {
        let j = (i + 1) % n;
        triangles.extend([[i, j, j + n], [i, j + n, i + n]]);
    }
    (vertices, triangles)
}

fn box_mesh(half: DVec3) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let outline = [(-half.x, -half.y), (half.x, -half.y), (half.x, half.y), (-half.x, half.y)];
    prism(&outline, &[[0, 1, 2], [0, 2, 3]], 2.0 * half.z)
}

/// An L: it has an edge that points inward.
fn angle_iron() -> TriangleMesh {
    let outline = [(0.0, 0.0), (0.03, 0.0), (0.03, 0.012), (0.012, 0.012), (0.012, 0.03), (0.0, 0.03)];
    let (vertices, triangles) = prism(&outline, &[[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]], 0.02);
    let turn = DQuat::from_scaled_axis(DVec3::new(0.3, -0.7, 0.4));
    mesh(vertices.into_iter().map(|v| turn * (v - DVec3::splat(0.01))).collect(), triangles)
}

const HALF: DVec3 = DVec3::new(0.02, 0.03, 0.01);

fn solids() -> Vec<Solid> {
    let (vertices, triangles) = box_mesh(HALF);
    vec![
        Solid::Cuboid { half: HALF },
        Solid::Cylinder { radius: 0.02, half_length: 0.035 },
        Solid::Mesh(Arc::new(mesh(vertices, triangles))),
        Solid::Mesh(Arc::new(angle_iron())),
        hook(),
    ]
}

/// A stem on a foot, and a pin through both that sticks out of neither's side.
fn hook() -> Solid {
    let piece = |solid: Solid, x: f64, z: f64, turn: f64| Placed {
        solid,
        pose: Pose { translation: DVec3::new(x, 0.0, z), rotation: DQuat::from_rotation_x(turn) },
    };
    let block = |x: f64, y: f64, z: f64| Solid::Cuboid { half: DVec3::new(x, y, z) };
    let pin = Solid::Cylinder { radius: 0.006, half_length: 0.008 };
    Solid::Assembly(
        vec![
            piece(block(0.01, 0.01, 0.02), 0.012, 0.01, 0.0),
            piece(block(0.025, 0.018, 0.008), 0.0, -0.018, 0.0),
            piece(pin, -0.012, 0.0, FRAC_PI_2),
        ]
        .into(),
    )
}

fn random_point(rng: &mut ChaCha8Rng, reach: f64) -> DVec3 {
    DVec3::from_array(std::array::from_fn(|_| rng.random_range(-reach..reach)))
}

#[test]
fn derivatives_agree_with_central_differences() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for solid in solids() {
        let (mut normals, mut curvatures, mut curved, count) = (0, 0, 0, 4000);
        for _ in 0..count {
            let point = random_point(&mut rng, 0.06);
            let here = solid.project(point);
            let slope = |h: f64| {
                DVec3::from_array(std::array::from_fn(|k| {
                    let step = h * DVec3::AXES[k];
                    (solid.project(point + step).distance - solid.project(point - step).distance) / (2.0 * h)
                }))
            };
            let bend = |h: f64| {
                DMat3::from_cols_array_2d(&std::array::from_fn(|k| {
                    let step = h * DVec3::AXES[k];
                    ((solid.project(point + step).normal - solid.project(point - step).normal) / (2.0 * h)).to_array()
                }))
            };
            // Two step sizes disagree only across a crease of the field: the medial axis, or the border of a feature.
            let (fine, coarse) = (slope(1e-7), slope(2e-7));
            if fine.distance(coarse) < 1e-6 {
                normals += 1;
                assert!((fine - here.normal).length() < 1e-6, "{solid:?} at {point}: {fine} vs {}", here.normal);
                assert!((here.normal.length() - 1.0).abs() < 1e-12);
            }
            let (fine, coarse) = (bend(1e-7), bend(2e-7));
            let size = |m: DMat3| m.to_cols_array().iter().map(|x| x * x).sum::<f64>().sqrt();
            if size(fine - coarse) < 1e-4 * (1.0 + size(fine)) {
                curvatures += 1;
                curved += usize::from(size(fine) > 1.0);
                let error = size(fine - here.curvature);
                assert!(error < 1e-3 * (1.0 + size(fine)), "{solid:?} at {point}: {fine} vs {}", here.curvature);
            }
        }
        assert!(normals > count * 99 / 100 && curvatures > count * 97 / 100, "{normals} and {curvatures} of {count}");
        assert!(curved > count / 5, "only {curved} points tried a curvature");
    }
}

/// Points of the mesh's triangles, on a lattice of barycentric coordinates.
fn lattice(mesh: &TriangleMesh, cuts: u32) -> Vec<DVec3> {
    let corners = mesh.triangles.iter().map(|t| t.map(|v| mesh.vertices[v as usize]));
    let weights =
        (0..=cuts).flat_map(|i| (0..=cuts - i).map(move |j| (i as f64 / cuts as f64, j as f64 / cuts as f64)));
    corners.flat_map(|[a, b, c]| weights.clone().map(move |(u, v)| a + u * (b - a) + v * (c - a))).collect()
}

/// Solid angles add to 4π inside and to 0 outside (van Oosterom & Strackee 1983).
fn is_inside(mesh: &TriangleMesh, point: DVec3) -> bool {
    let angle = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| mesh.vertices[v as usize] - point);
        let (la, lb, lc) = (a.length(), b.length(), c.length());
        2.0 * a.dot(b.cross(c)).atan2(la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb)
    };
    mesh.triangles.iter().map(angle).sum::<f64>() > 2.0 * PI
}

#[test]
fn mesh_distances_are_those_of_brute_force() {
    let mesh = angle_iron();
    let (samples, solid) = (lattice(&mesh, 50), Solid::Mesh(Arc::new(mesh.clone())));
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let mut inside = 0;
    for _ in 0..2000 {
        let point = random_point(&mut rng, 0.022);
        let field = solid.project(point);
        let nearest = samples.iter().map(|s| s.distance(point)).fold(f64::INFINITY, f64::min);
        let excess = nearest - field.distance.abs();
        assert!((-1e-12..6e-4).contains(&excess), "distance {} at {point}, nearest sample {nearest}", field.distance);
        assert_eq!(field.distance < 0.0, is_inside(&mesh, point), "sign of {} at {point}", field.distance);
        inside += usize::from(field.distance < 0.0);
        let foot = solid.project(point - field.distance * field.normal);
        assert!(foot.distance.abs() < 1e-12, "following the normal from {point} ends {} off", foot.distance);
    }
    assert!(inside > 200);
}

#[test]
fn a_mesh_of_a_box_is_the_box() {
    let (vertices, triangles) = box_mesh(HALF);
    let (faceted, exact) = (Solid::Mesh(Arc::new(mesh(vertices, triangles))), Solid::Cuboid { half: HALF });
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let near_edges = (0..2000).map(|i| {
        let corner = DVec3::new((i & 1) as f64, (i & 2) as f64 / 2.0, (i & 4) as f64 / 4.0) * 2.0 - DVec3::ONE;
        corner * HALF
    });
    let near_edges: Vec<_> = near_edges.map(|c| c + random_point(&mut rng, 1e-3)).collect();
    let anywhere = (0..4000).map(|_| random_point(&mut rng, 0.06));
    // Exactly above the diagonal between two triangles of one face, and above a face's border.
    let borders = (0..200).map(|i| HALF * DVec3::new(i as f64 / 100.0 - 1.0, i as f64 / 100.0 - 1.0, 1.7));
    let borders: Vec<_> =
        borders.chain((0..200).map(|i| HALF * DVec3::new(1.0, i as f64 / 101.0 - 1.0, 1.3))).collect();
    for point in anywhere.chain(near_edges).chain(borders) {
        let (a, b) = (faceted.project(point), exact.project(point));
        assert!((a.distance - b.distance).abs() < 1e-14, "{} vs {} at {point}", a.distance, b.distance);
        // Inside, two faces at nearly equal distance may be told apart in either way.
        let excess = point.abs() - HALF;
        let mut order = excess.to_array();
        order.sort_by(f64::total_cmp);
        if b.distance > 0.0 || order[2] - order[1] > 1e-7 {
            assert!(a.normal.distance(b.normal) < 1e-9, "{} vs {} at {point}", a.normal, b.normal);
            let bend = (a.curvature - b.curvature).to_cols_array().iter().fold(0.0, |m: f64, x| m.max(x.abs()));
            let on_border = (excess.x == 0.0) as u8 + (excess.y == 0.0) as u8 > 0;
            assert!(on_border || bend * b.distance.abs() < 1e-9, "{} vs {} at {point}", a.curvature, b.curvature);
        }
    }
}

#[test]
fn closed_forms_have_the_right_sign_and_reach_the_surface() {
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let (radius, half_length) = (0.02, 0.035);
    let cylinder = Solid::Cylinder { radius, half_length };
    for _ in 0..4000 {
        let p = random_point(&mut rng, 0.05);
        let inside = p.x.hypot(p.z) < radius && p.y.abs() < half_length;
        let field = cylinder.project(p);
        assert_eq!(inside, field.distance < 0.0);
        assert!(cylinder.project(p - field.distance * field.normal).distance.abs() < 1e-12);
        assert_eq!(p.abs().cmplt(HALF).all(), Solid::Cuboid { half: HALF }.project(p).distance < 0.0);
    }
}

#[test]
fn triangles_in_any_order_and_facing_become_the_same_solid() {
    let (vertices, mut triangles) = box_mesh(HALF);
    for (i, t) in triangles.iter_mut().enumerate() {
        if i % 3 == 0 {
            t.swap(0, 1);
        }
    }
    // A soup, as STL files hold it: every triangle with its own corners, and one triangle without area.
    let mut soup: Vec<DVec3> = triangles.iter().flatten().map(|&v| vertices[v as usize]).collect();
    soup.extend([vertices[0], vertices[1], (vertices[0] + vertices[1]) / 2.0]);
    let corners = (0..soup.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let welded = mesh(soup, corners);
    assert_eq!((welded.vertices.len(), welded.triangles.len(), welded.closure), (8, 12, Closure::Watertight));
    assert!((welded.volume() - 8.0 * HALF.element_product()).abs() < 1e-18);
}

#[test]
fn a_mesh_with_a_hole_becomes_its_hull_and_says_so() {
    let (vertices, mut triangles) = box_mesh(HALF);
    triangles.pop();
    let open = mesh(vertices, triangles);
    assert_eq!(open.closure, Closure::ConvexHull);
    assert!((open.volume() / (8.0 * HALF.element_product()) - 1.0).abs() < 1e-6);
    let (hull, exact) = (Solid::Mesh(Arc::new(open)), Solid::Cuboid { half: HALF });
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    for _ in 0..1000 {
        let point = random_point(&mut rng, 0.05);
        assert!((hull.project(point).distance - exact.project(point).distance).abs() < 1e-8);
    }
}

#[test]
fn impossible_meshes_are_refused_and_impossible_points_survived() {
    let (vertices, triangles) = box_mesh(HALF);
    assert!(TriangleMesh::new(vertices.clone(), vec![]).is_err());
    assert!(TriangleMesh::new(vertices.clone(), vec![[0, 1, 99]]).is_err());
    assert!(TriangleMesh::new(vec![DVec3::NAN; 3], vec![[0, 1, 2]]).is_err());
    assert!(TriangleMesh::new(vertices.clone(), vec![[0, 1, 2]]).is_err(), "one triangle encloses nothing");
    assert!(TriangleMesh::new(vec![DVec3::ZERO; 3], vec![[0, 1, 2]]).is_err());
    let flat = vertices.iter().map(|v| v.with_z(0.0)).collect();
    assert!(TriangleMesh::new(flat, triangles.clone()).is_err(), "a flat box encloses nothing");
    let solid = Solid::Mesh(Arc::new(mesh(vertices, triangles)));
    assert!(solid.project(DVec3::NAN).distance.is_nan());
    assert!((solid.project(DVec3::splat(1e30)).distance / (3f64.sqrt() * 1e30) - 1.0).abs() < 1e-9);
}

#[test]
fn surface_samples_lie_on_the_surface_face_outward_and_leave_no_hole() {
    for solid in solids() {
        let (coarse, fine) = (solid.surface(0.005), solid.surface(0.0015));
        assert_eq!(coarse, solid.surface(0.005));
        for point in &coarse {
            let out = solid.project(point.position + 1e-5 * point.normal);
            assert!((out.distance - 1e-5).abs() < 1e-12, "{point:?} is not on {solid:?}: {}", out.distance);
            assert!(out.normal.distance(point.normal) < 1e-9);
        }
        for at in &fine {
            let nearest = coarse.iter().map(|p| p.position.distance(at.position)).fold(f64::INFINITY, f64::min);
            assert!(nearest < 0.0055, "a hole of {nearest} m at {at:?} in {solid:?}");
        }
        for (i, p) in coarse.iter().enumerate() {
            let mut others = coarse[..i].iter().map(|q| q.position.distance(p.position));
            assert!(others.all(|d| d > 0.0015), "two samples of {solid:?} nearly coincide at {p:?}");
        }
    }
}
