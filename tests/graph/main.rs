//! Edges found through the cell list are those that all pairs give, in the promised order.
use glam::{DQuat, DVec3};
use pliant::graph::{EDGE_KINDS, EdgeSet, Graph, GraphSpec, Nodes, near_kinds};
use pliant::state::{Part, Particles, Pose, Solid, SurfacePoint, ToolShape, Wall};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::json;
use std::sync::Arc;

mod skeleton;

const INTERVAL: f64 = 0.1;
/// Stands across the clouds.
const WALL: Wall = Wall { normal: DVec3::new(0.6, 0.8, 0.0), offset: -0.01 };

fn connect(points: &[DVec3], tool: &ToolShape, poses: &[Pose], radius: f64, kinds: &[&str]) -> Graph {
    let spec = json!({ "kind": "radius", "radius": radius, "edges": kinds });
    let policy = serde_json::from_value::<GraphSpec>(spec).unwrap().build().unwrap();
    assert_eq!(policy.reach(), radius);
    let before: Vec<_> = poses.iter().map(|p| Pose { translation: p.translation + DVec3::Z * 0.01, ..*p }).collect();
    let particles = Particles::at_rest(points.to_vec());
    policy.connect(Nodes::gather(&particles, &Arc::default(), &[WALL], tool, &before, poses, INTERVAL))
}

fn all_kinds() -> Vec<&'static str> {
    near_kinds().map(|k| k.name()).collect()
}

fn tool(rng: &mut ChaCha8Rng, parts: usize, samples: usize) -> (ToolShape, Vec<Pose>) {
    let surface = |rng: &mut ChaCha8Rng| {
        let point = |rng: &mut ChaCha8Rng| SurfacePoint { position: cloud(rng, 1, 0.03)[0], normal: DVec3::X };
        (0..samples).map(|_| point(rng)).collect()
    };
    let solid = || Solid::Cuboid { half: DVec3::splat(0.03) };
    let shape = ToolShape::from((0..parts).map(|_| Part { solid: solid(), surface: surface(rng) }).collect::<Vec<_>>());
    let pose =
        |_| Pose { translation: cloud(rng, 1, 0.03)[0], rotation: DQuat::from_scaled_axis(cloud(rng, 1, 2.0)[0]) };
    (shape, (0..parts).map(pose).collect())
}

fn cloud(rng: &mut ChaCha8Rng, count: usize, size: f64) -> Vec<DVec3> {
    (0..count).map(|_| DVec3::from_array(std::array::from_fn(|_| rng.random_range(-size..size)))).collect()
}

/// Every kind's edges as (receiver, sender) from all pairs.
fn all_pairs(graph: &Graph, radius: f64) -> Vec<Vec<(usize, usize)>> {
    let nodes = &graph.nodes;
    let joined = |i: usize, j: usize| match j {
        _ if j == nodes.len() - 1 => nodes.positions[i].z < radius,
        _ if j == nodes.len() - 2 => nodes.positions[i].dot(WALL.normal) + 0.01 < radius,
        _ => i != j && (nodes.positions[i] - nodes.positions[j]).length_squared() < radius * radius,
    };
    let ranges = [0..nodes.particles, nodes.particles..nodes.len() - 2, nodes.len() - 2..nodes.len()];
    let row = |i: usize, range: std::ops::Range<usize>| range.filter(move |j| joined(i, *j)).map(move |j| (i, j));
    ranges.map(|r| (0..nodes.particles).flat_map(|i| row(i, r.clone())).collect()).to_vec()
}

fn assert_matches(points: &[DVec3], tool: &ToolShape, poses: &[Pose], radius: f64) -> usize {
    let graph = connect(points, tool, poses, radius, &all_kinds());
    let expected = all_pairs(&graph, radius);
    assert_eq!(graph.edges.len(), EDGE_KINDS.len());
    for (set, expected) in graph.edges.iter().zip(&expected) {
        assert_eq!(set.offsets.len(), points.len() + 1);
        assert_eq!(*set.offsets.last().unwrap() as usize, set.len());
        let pairs: Vec<_> = set.pairs().collect();
        assert!(pairs.is_sorted(), "by receiver, then by sender");
        assert_eq!(&pairs, expected, "{} points, radius {radius}", points.len());
    }
    expected.iter().map(Vec::len).sum()
}

#[test]
fn a_degree_keeps_the_nearest_of_every_kind() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let (shape, poses) = tool(&mut rng, 2, 40);
    let points = cloud(&mut rng, 60, 0.03);
    let all = connect(&points, &shape, &poses, 0.05, &all_kinds());
    for degree in [1, 3, 1000] {
        let spec = json!({ "kind": "radius", "radius": 0.05, "edges": all_kinds(), "degree": degree });
        let policy = serde_json::from_value::<GraphSpec>(spec).unwrap().build().unwrap();
        let kept = policy.connect(all.nodes.clone());
        let positions = &kept.nodes.positions;
        for (every, few) in all.edges.iter().zip(&kept.edges) {
            let senders = |set: &EdgeSet, i| set.pairs().filter(|p| p.0 == i).map(|p| p.1).collect::<Vec<_>>();
            for i in 0..points.len() {
                let (every, few) = (senders(every, i), senders(few, i));
                assert_eq!(few.len(), every.len().min(degree));
                assert!(few.is_sorted() && few.iter().all(|j| every.contains(j)));
                let far = |j: &&usize| positions[i].distance(positions[**j]);
                let farthest = few.iter().map(|j| far(&j)).fold(0.0, f64::max);
                assert!(every.iter().filter(|j| !few.contains(j)).all(|j| far(&j) >= farthest));
            }
        }
    }
    let spec = json!({ "kind": "radius", "radius": 0.05, "edges": all_kinds(), "degree": 0 });
    let refusal = serde_json::from_value::<GraphSpec>(spec).unwrap().build().err().unwrap();
    assert!(refusal.to_string().contains("graph.degree"), "{refusal}");
}

#[test]
fn random_clouds_agree_with_all_pairs() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut found = 0;
    for trial in 0..60 {
        let (shape, poses) = tool(&mut rng, trial % 3 + 1, [0, 1, 40][trial % 3]);
        let count = [0, 1, 2, 7, 60, 150][trial % 6];
        let points = cloud(&mut rng, count, [0.02, 0.1, 5.0][trial / 3 % 3]);
        found += assert_matches(&points, &shape, &poses, [0.01, 0.03, 0.2][trial / 9 % 3]);
    }
    assert!(found > 10_000, "the clouds have edges to find: {found}");
}

#[test]
fn degenerate_clouds_agree_with_all_pairs() {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let (shape, poses) = tool(&mut rng, 2, 10);
    let bare = ToolShape::from(Vec::new());
    let coincident = vec![DVec3::new(0.3, -0.2, 0.004); 20];
    assert_eq!(assert_matches(&coincident, &bare, &[], 0.01), 20 * 19 + 20);
    assert_eq!(assert_matches(&[], &bare, &[], 0.01), 0);
    assert_eq!(assert_matches(&[DVec3::Z], &bare, &[], 0.01), 0);
    assert_eq!(assert_matches(&[DVec3::ZERO], &bare, &[], 0.01), 1);
    // All in one cell; two far apart; exactly one radius apart, which is not within it; points on cell borders.
    assert_matches(&cloud(&mut rng, 50, 0.001), &shape, &poses, 0.5);
    assert_matches(&[DVec3::splat(-1e6), DVec3::splat(1e6), DVec3::splat(1e6 + 0.001)], &shape, &poses, 0.01);
    // The wall alone is near to both.
    assert_eq!(assert_matches(&[DVec3::Z, DVec3::Z * 1.5], &bare, &[], 0.5), 2);
    let lattice: Vec<_> =
        (0..125).map(|i| DVec3::new((i % 5) as f64, (i / 5 % 5) as f64, (i / 25) as f64) * 0.25).collect();
    assert!(assert_matches(&lattice, &bare, &[], 0.25 + 1e-9) > 500);
    assert_matches(&lattice, &bare, &[], 0.25);
}

#[test]
fn a_particle_at_no_number_has_no_neighbours_and_breaks_nothing() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let (shape, poses) = tool(&mut rng, 1, 10);
    for bad in [DVec3::NAN, DVec3::INFINITY, DVec3::new(0.0, f64::NAN, 0.0)] {
        let mut points = cloud(&mut rng, 30, 0.02);
        points[7] = bad;
        let graph = connect(&points, &shape, &poses, 0.02, &["particle", "tool"]);
        assert!(graph.edges.iter().flat_map(|set| set.pairs()).all(|(i, j)| i != 7 && j != 7));
    }
}

#[test]
fn every_kind_can_be_drawn_alone() {
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let (shape, poses) = tool(&mut rng, 1, 30);
    let points = cloud(&mut rng, 60, 0.02);
    let together = connect(&points, &shape, &poses, 0.03, &all_kinds());
    for (k, kind) in near_kinds().enumerate() {
        let alone = connect(&points, &shape, &poses, 0.03, &[kind.name()]);
        assert!(!alone.edges[k].is_empty(), "{} is reachable", kind.name());
        assert_eq!(alone.edges[k], together.edges[k]);
        assert!(alone.edges.iter().enumerate().all(|(other, set)| other == k || set.is_empty()));
        assert!(alone.edges.iter().all(|set| set.offsets.len() == points.len() + 1));
    }
}

#[test]
fn tool_samples_move_with_their_part() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let (shape, poses) = tool(&mut rng, 2, 5);
    let nodes = connect(&[DVec3::Z], &shape, &poses, 0.03, &all_kinds()).nodes;
    let locals = shape.parts.iter().flat_map(|p| &p.surface);
    for (row, local) in nodes.tool().zip(locals) {
        let pose = poses[nodes.parts[row].unwrap() as usize];
        assert!(nodes.positions[row].distance(pose.apply(local.position)) < 1e-12);
        assert!(nodes.velocities[row].distance(DVec3::Z * -0.01 / INTERVAL) < 1e-12);
    }
    assert_eq!((nodes.parts[0], &nodes.parts[nodes.planes()]), (None, &[None; 2][..]));
    assert_eq!(nodes.normals[nodes.planes()], [WALL.normal, DVec3::Z]);
}
