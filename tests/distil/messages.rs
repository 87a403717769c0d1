//! Messages are what the law does, and what shrinks them has their exact derivative.
use glam::DVec3;
use pliant::model::law::{LawSpec, LearnedPairSpec};
use pliant::model::particles::ParticlesSpec;
use pliant::model::{ModelSpec, WorldModel};
use pliant::state::{Control, Particles, Scene};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::sync::Arc;

/// A network between particles and with the table, at `weights` drawn from a seed.
pub(crate) fn pair() -> LearnedPairSpec {
    let text = "width = 6\nedges = [\"particle\", \"floor\"]\nradius = 0.016\nskin = 0.006\nstrength = 2.0\nspeed = 0.05\nseed = 3";
    toml_edit::de::from_str(text).unwrap()
}

/// Under that law alone, a control step being one substep.
pub(crate) fn model(pair: LearnedPairSpec) -> ModelSpec {
    let spec = toml_edit::de::from_str("substeps = 1\nkeep = 1.0").unwrap();
    ModelSpec::Particles(ParticlesSpec { laws: vec![LawSpec::LearnedPair(pair)], ..spec })
}

fn shaken() -> Box<dyn WorldModel> {
    let mut model = model(pair()).build().unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let weights: Vec<f32> = model.weights().iter().map(|w| w + rng.random_range(-0.4..0.4)).collect();
    model.set_weights(&weights);
    model
}

fn scene(positions: Vec<DVec3>, velocities: Vec<DVec3>) -> (Scene, Control) {
    let scene = Scene::open(Particles { positions, velocities }, Arc::new(Vec::new().into()), Vec::new(), 1e-3);
    (scene, Control { poses: Vec::new() })
}

#[test]
fn a_message_is_the_acceleration_of_the_particle_that_is_met() {
    let (model, high) = (shaken(), DVec3::new(0.0, 0.0, 0.1));
    let (x, v) = ([high, high + DVec3::new(0.006, 0.007, -0.002)], [DVec3::new(0.03, -0.02, 0.01), DVec3::ZERO]);
    let (scene, control) = scene(x.to_vec(), v.to_vec());
    let messages = model.messages(&scene, &control);
    assert_eq!(messages.len(), 1);
    let m = messages[0];
    let (normal, velocity) = ((x[0] - x[1]).normalize(), v[0] - v[1]);
    let sliding = velocity - velocity.dot(normal) * normal;
    assert!((m.distance - x[0].distance(x[1])).abs() < 1e-15 && (m.separating - velocity.dot(normal)).abs() < 1e-15);
    assert!((m.sliding - sliding.length()).abs() < 1e-15);
    let next = &model.rollout(&scene, std::slice::from_ref(&control))[1];
    let expected = m.normal * normal + m.tangential * sliding.normalize();
    assert!(expected.length() > 1e-3, "the network says nothing");
    for (i, sign) in [(0, 1.0), (1, -1.0)] {
        let acceleration = (next.velocities[i] - v[i]) / 1e-3;
        assert!((acceleration - sign * expected).length() < 1e-9, "{acceleration} is not {sign} times {expected}");
    }
}

#[test]
fn the_derivative_of_messages_agrees_with_central_differences() {
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    let mut at = |scale: f64| DVec3::from_array(std::array::from_fn(|_| scale * rng.random::<f64>()));
    let (x, v): (Vec<DVec3>, Vec<DVec3>) = (0..8).map(|_| (at(0.02), at(0.1))).unzip();
    let (scene, control) = scene(x, v);
    let mut model = shaken();
    let messages = model.messages(&scene, &control);
    assert!([0, 2].iter().all(|kind| messages.iter().any(|m| m.kind == *kind)), "both kinds must meet");
    let at: Vec<[f64; 2]> =
        messages.iter().map(|_| [rng.random_range(-1.0..1.0), rng.random_range(-1.0..1.0)]).collect();
    let mut weights = vec![0.0; model.weights().len()];
    model.messages_vjp(&scene, &control, &at, &mut weights);
    let start = model.weights();
    for k in (0..start.len()).step_by(7) {
        let mut nudged = |h: f32| {
            let mut moved = start.clone();
            moved[k] += h;
            model.set_weights(&moved);
            let said = model.messages(&scene, &control);
            let sum: f64 = said.iter().zip(&at).map(|(m, at)| m.normal * at[0] + m.tangential * at[1]).sum();
            (sum, f64::from(moved[k]))
        };
        let ((above, right), (below, left)) = (nudged(1e-2), nudged(-1e-2));
        let difference = (above - below) / (right - left);
        let exact = f64::from(weights[k]);
        assert!(
            (exact - difference).abs() < 1e-3 * difference.abs().max(0.05),
            "weight {k}: {exact} against {difference}"
        );
    }
}
