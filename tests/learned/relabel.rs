//! Relabelling particles relabels what a learned model predicts bit for bit, whatever it is told and whatever graph it draws.
use crate::moment::*;
use glam::DVec3;
use pliant::model::{ModelSpec, WorldModel};
use pliant::state::{Control, Particles, Scene};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};
use std::sync::Arc;

const COUNT: usize = 40;
/// Rows of particles that only their past tells apart, four of one body and three of the other.
const TWINS: [&[usize]; 2] = [&[4, 10, 22, 28], &[3, 9, 21]];
/// Rows that only their body tells apart.
const STRANGERS: [usize; 2] = [12, 13];

/// Two bodies with a memory between walls, under a tool that moves on.
fn scene() -> (Scene, Vec<Control>) {
    let mut here = Moment::random(COUNT).walled().remembering(2);
    let Moment { particles: Particles { positions, velocities }, past, body, .. } = &mut here;
    for twins in TWINS {
        for &i in twins {
            (positions[i], velocities[i]) = (positions[twins[0]], velocities[twins[0]]);
        }
        assert!(twins.iter().all(|&i| body[i] == body[twins[0]]));
    }
    let [one, other] = STRANGERS;
    for rows in [positions, velocities].into_iter().chain(past) {
        rows[other] = rows[one];
    }
    assert_ne!(body[one], body[other]);
    let poses = here.poses.clone();
    let moved = |t: usize| {
        let mut poses = poses.clone();
        poses.iter_mut().for_each(|pose| pose.translation += t as f64 * DVec3::new(0.002, -0.001, -0.001));
        Control { poses }
    };
    let scene = Scene::open(here.particles, Arc::new(here.tool), poses.clone(), INTERVAL);
    let scene = Scene { past: here.past, body: here.body.into(), walls: here.walls.into(), ..scene };
    (scene, (1..=3).map(moved).collect())
}

/// A network out of its zero start, of particles under this graph, the bodies of some numbers rigid.
fn model(graph: &Value, rigid: &[u32]) -> Box<dyn WorldModel> {
    let law = json!({
        "kind": "learned", "width": 16, "rounds": 2, "sharing": "shared", "history": 3, "bodies": 2, "edges": graph["edges"],
        "radius": RADIUS, "scale": SCALE, "seed": 1,
    });
    let spec =
        json!({ "kind": "particles", "substeps": 1, "keep": 0.5, "rigid": rigid, "graph": graph, "laws": [law] });
    let mut model = serde_json::from_value::<ModelSpec>(spec).unwrap().build().unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(17);
    let weights: Vec<f32> = model.weights().iter().map(|w| w + rng.random_range(-0.15..0.15)).collect();
    model.set_weights(&weights);
    model
}

#[test]
fn relabelling_particles_that_only_their_past_tells_apart_relabels_the_prediction_bit_for_bit() {
    let (scene, controls) = scene();
    let near = json!(["particle", "tool", "floor"]);
    let rooted = json!(["particle", "tool", "floor", "leaf_root", "root_root", "root_leaf"]);
    let bonded = json!(["particle", "tool", "floor", "bond"]);
    let graphs = [
        json!({ "kind": "radius", "radius": RADIUS, "edges": near }),
        json!({ "kind": "radius", "radius": RADIUS, "edges": near, "degree": 2 }),
        json!({ "kind": "hierarchy", "radius": RADIUS, "edges": rooted, "roots": [6, 2] }),
        json!({ "kind": "hierarchy", "radius": RADIUS, "edges": rooted, "roots": [4], "bodies": [1] }),
        json!({ "kind": "fixed", "radius": RADIUS, "edges": bonded }),
        json!({ "kind": "fixed", "radius": RADIUS, "edges": bonded, "degree": 2 }),
    ];
    for (graph, rigid) in graphs.iter().flat_map(|graph| [&[][..], &[1]].map(|rigid| (graph, rigid))) {
        let model = model(graph, rigid);
        let direct = model.rollout(&scene, &controls);
        let end = &direct[3].positions;
        let [loose, _] = TWINS.map(|twins| (1..twins.len()).all(|k| end[twins[0]] != end[twins[k]]));
        assert!(loose && end[STRANGERS[0]] != end[STRANGERS[1]], "{graph}: the past and the body matter");
        let strides = [(39, 39), (17, 5), (3, 1), (11, 2), (29, 7), (13, 20)];
        for (stride, first) in strides {
            let order: Vec<usize> = (0..COUNT).map(|i| (i * stride + first) % COUNT).collect();
            let pick = |rows: &[DVec3]| -> Vec<DVec3> { order.iter().map(|&i| rows[i]).collect() };
            let relabel = |x: &Particles| Particles { positions: pick(&x.positions), velocities: pick(&x.velocities) };
            let relabelled = Scene {
                particles: relabel(&scene.particles),
                past: scene.past.iter().map(|rows| pick(rows)).collect(),
                body: order.iter().map(|&i| scene.body[i]).collect(),
                ..scene.clone()
            };
            let after = model.rollout(&relabelled, &controls);
            assert!(direct.iter().zip(&after).all(|(x, y)| relabel(x) == *y), "{graph}, rigid {rigid:?}");
        }
    }
}
