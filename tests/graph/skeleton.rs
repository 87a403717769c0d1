//! What a rollout keeps of its first graph: roots over the particles of every body, and bonds between them.
use super::{INTERVAL, cloud};
use glam::DVec3;
use pliant::graph::{EDGE_KINDS, Graph, GraphSpec, Nodes, Roots};
use pliant::state::{Particles, ToolShape};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde_json::json;
use std::sync::Arc;

/// Particles, and the graph with roots that a policy draws over them.
fn rooted(points: &[DVec3], counts: &[usize]) -> (Roots, Graph) {
    rooted_over(points, &vec![0; points.len()], json!({ "roots": counts }))
}

/// The same over bodies of these numbers, as the policy's `keys` say.
fn rooted_over(points: &[DVec3], body: &[u32], keys: serde_json::Value) -> (Roots, Graph) {
    let edges = ["particle", "leaf_root", "root_root", "root_leaf"];
    let mut spec = json!({ "kind": "hierarchy", "radius": 0.02, "edges": edges });
    spec.as_object_mut().unwrap().extend(keys.as_object().unwrap().clone());
    let policy = serde_json::from_value::<GraphSpec>(spec).unwrap().build().unwrap();
    let particles = Particles::at_rest(points.to_vec());
    let skeleton = Arc::new(policy.skeleton(&particles, body));
    let none = ToolShape::from(Vec::new());
    let graph = policy.connect(Nodes::gather(&particles, &skeleton, &[], &none, &[], &[], INTERVAL));
    (skeleton.roots.clone(), graph)
}

fn pairs(graph: &Graph, kind: &str) -> Vec<(usize, usize)> {
    let place = EDGE_KINDS.iter().position(|k| k.name() == kind).unwrap();
    graph.edges[place].pairs().collect()
}

#[test]
fn every_particle_has_one_root_a_level_and_every_root_stands_at_its_mean() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    for (count, counts) in [(60, vec![8]), (200, vec![12, 3]), (3, vec![8]), (1, vec![4, 2]), (40, vec![])] {
        let points = cloud(&mut rng, count, 0.1);
        let (roots, graph) = rooted(&points, &counts);
        let nodes = &graph.nodes;
        let below = |row: usize| -> Vec<usize> {
            let mut leaves: Vec<usize> = vec![row];
            while leaves.iter().any(|&leaf| leaf >= count) {
                let under = |&leaf: &usize| -> Vec<usize> {
                    let own =
                        pairs(&graph, "leaf_root").into_iter().filter(|(to, _)| *to == leaf).map(|(_, from)| from);
                    if leaf < count { vec![leaf] } else { own.collect() }
                };
                leaves = leaves.iter().flat_map(under).collect();
            }
            leaves
        };
        for level in roots.levels() {
            assert!(!level.is_empty());
            let mut all: Vec<usize> = level.clone().flat_map(below).collect();
            all.sort_unstable();
            assert_eq!(all, (0..count).collect::<Vec<_>>(), "each particle once under the roots of a level");
            for root in level.clone() {
                let leaves = below(root);
                let mean = leaves.iter().map(|&i| points[i]).sum::<DVec3>() / leaves.len() as f64;
                assert!(nodes.positions[root].distance(mean) < 1e-15);
                let own = |p: &DVec3| p.distance_squared(nodes.positions[root]);
                if level.start == count {
                    let nearer = level.clone().any(|r| {
                        leaves.iter().any(|&i| points[i].distance_squared(nodes.positions[r]) < own(&points[i]) - 1e-15)
                    });
                    assert!(!nearer, "a particle is nearer to another root's mean than to its own");
                }
            }
            let among = pairs(&graph, "root_root").into_iter().filter(|(to, _)| level.contains(to));
            assert_eq!(among.count(), level.len() * (level.len() - 1));
        }
        let mut up = pairs(&graph, "leaf_root");
        let mut down: Vec<_> = pairs(&graph, "root_leaf").into_iter().map(|(to, from)| (from, to)).collect();
        assert!(up.is_sorted() && pairs(&graph, "root_leaf").is_sorted() && pairs(&graph, "root_root").is_sorted());
        up.sort_unstable();
        down.sort_unstable();
        assert_eq!(up, down, "what goes up comes down");
    }
}

#[test]
fn every_body_has_roots_of_its_own_or_none() {
    let points = cloud(&mut ChaCha8Rng::seed_from_u64(8), 90, 0.1);
    let body: Vec<u32> = (0..90).map(|i| [2, 0, 1][i % 3]).collect();
    let (all, graph) = rooted_over(&points, &body, json!({ "roots": [6, 2] }));
    assert_eq!(all.len(), 3 * (6 + 2));
    let of = all.with_bodies(&body);
    let kinds = ["leaf_root", "root_root", "root_leaf"];
    for (to, from) in kinds.iter().flat_map(|kind| pairs(&graph, kind)) {
        assert_eq!(of[to], of[from], "an edge of the hierarchy leads to another body");
    }
    let (some, graph) = rooted_over(&points, &body, json!({ "roots": [6], "bodies": [1] }));
    assert_eq!(some.len(), 6);
    let mut under: Vec<usize> = pairs(&graph, "leaf_root").into_iter().map(|(_, leaf)| leaf).collect();
    under.sort_unstable();
    assert_eq!(under, (0..90).filter(|&i| body[i] == 1).collect::<Vec<_>>());
}

#[test]
fn bonds_join_what_was_near_and_stay() {
    let spec = json!({ "kind": "fixed", "radius": 0.03, "edges": ["particle", "bond", "floor"] });
    let bonded = |degree: serde_json::Value| {
        let mut spec = spec.clone();
        spec["degree"] = degree;
        serde_json::from_value::<GraphSpec>(spec).unwrap().build().unwrap()
    };
    let policy = bonded(json!(null));
    let points = cloud(&mut ChaCha8Rng::seed_from_u64(9), 80, 0.03);
    let body: Vec<u32> = (0..80).map(|i| u32::from(i % 4 == 0)).collect();
    let particles = Particles::at_rest(points.clone());
    let skeleton = Arc::new(policy.skeleton(&particles, &body));
    let none = ToolShape::from(Vec::new());
    // Everything is torn apart: nothing is near any more.
    let moved = Particles::at_rest(points.iter().map(|x| 100.0 * *x).collect());
    let graph = policy.connect(Nodes::gather(&moved, &skeleton, &[], &none, &[], &[], INTERVAL));
    let near = |i: usize, j: usize| i != j && body[i] == body[j] && points[i].distance(points[j]) < 0.03;
    let expected: Vec<_> = (0..80).flat_map(|i| (0..80).map(move |j| (i, j))).filter(|&(i, j)| near(i, j)).collect();
    assert_eq!(pairs(&graph, "bond"), expected);
    assert!(expected.len() > 100 && pairs(&graph, "particle").is_empty());

    let few = bonded(json!(3)).skeleton(&particles, &body).bonds;
    assert!(few.offsets.windows(2).all(|ends| ends[1] - ends[0] <= 3) && few.len() > 80);
    assert!(few.pairs().all(|pair| expected.contains(&pair)));
}

#[test]
fn impossible_hierarchies_are_sentences() {
    let spec = |kind: &str, edges: &[&str], roots: serde_json::Value| {
        let mut spec = json!({ "kind": kind, "radius": 0.02, "edges": edges });
        if !roots.is_null() {
            spec["roots"] = roots;
        }
        serde_json::from_value::<GraphSpec>(spec).unwrap().build().map(|_| ()).unwrap_err().to_string()
    };
    assert!(spec("radius", &["leaf_root"], json!(null)).contains("hierarchy"));
    assert!(spec("hierarchy", &["bond"], json!([])).contains("graph.kind = \"fixed\""));
    assert!(spec("fixed", &["root_leaf"], json!(null)).contains("graph.kind = \"hierarchy\""));
    assert!(spec("hierarchy", &["particle"], json!([8, 8])).contains("graph.roots"));
    assert!(spec("hierarchy", &["particle"], json!([0])).contains("graph.roots"));
}
