//! Constants that a network sets for each pair: exact derivatives, momentum, bounds, and their start.
use super::constants;
use super::*;
use pliant::model::law::{NeuralConstants, NeuralConstantsSpec};
use rand::Rng;
use serde_json::json;

const BOUND: f64 = 0.7;

/// Around the analytical model's laws between particles, as far as `keep` keeps them.
fn spec(keep: impl Fn(&str) -> bool) -> NeuralConstantsSpec {
    let mut laws = analytic_spec().laws;
    laws.retain(|law| ["contact", "cohesion", "viscosity"].contains(&&*law.called()) && keep(&law.called()));
    NeuralConstantsSpec { width: 8, bound: BOUND, radius: 0.015, speed: 0.02, seed: 3, laws, weights: None }
}

/// Shaken out of its zero start by multiples of 1/64, which f32 holds exactly.
fn shaken(spec: NeuralConstantsSpec) -> NeuralConstants {
    let mut law = spec.build().unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let weights: Vec<f32> =
        law.weights().iter().map(|w| ((w + rng.random_range(-0.4..0.4)) * 64.0).round() / 64.0).collect();
    law.set_weights(&weights);
    law
}

/// With the analytical model's other laws.
fn among(law: NeuralConstants) -> ParticleModel {
    let others = analytic_laws().into_iter().skip(3);
    ParticleModel::new(40, 0.01, None, std::iter::once(Box::new(law) as Box<dyn Law>).chain(others).collect()).unwrap()
}

#[test]
fn the_gradient_through_constants_of_a_network_agrees_with_central_differences() {
    for name in ["contact", "cohesion", "viscosity"] {
        check(&among(shaken(spec(|law| law == name))), name, |_| ());
    }
    check(&among(shaken(spec(|_| true))), "all", |_| ());
}

#[test]
fn its_weight_gradient_agrees_with_central_differences() {
    let problem = problem(&mut ChaCha8Rng::seed_from_u64(11));
    let mut model = among(shaken(spec(|_| true)));
    let gradient = model.weight_gradient(&problem.0, &problem.1, &problem.2).unwrap();
    let weights = WorldModel::weights(&model);
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    for _ in 0..8 {
        // Signs times a power of two, which f32 adds exactly.
        let signs: Vec<f32> = weights.iter().map(|_| if rng.random::<bool>() { 1.0 } else { -1.0 }).collect();
        let mut nudged = |h: f32| {
            let moved: Vec<f32> = weights.iter().zip(&signs).map(|(w, s)| w + h * s).collect();
            WorldModel::set_weights(&mut model, &moved);
            problem.2.total(&model.rollout(&problem.0, &problem.1))
        };
        let h = 2.0_f32.powi(-17);
        let difference = (nudged(h) - nudged(-h)) / (2.0 * f64::from(h));
        let exact: f64 = gradient.weights.iter().zip(&signs).map(|(g, s)| f64::from(g * s)).sum();
        assert!(difference.abs() > 1e-4, "the weights do nothing: {difference}");
        assert!((exact - difference).abs() <= 1e-4 * difference.abs().max(0.1), "{exact} against {difference}");
    }
}

#[test]
fn derivatives_by_the_written_constants_agree_with_central_differences() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("weights.safetensors");
    let law = shaken(spec(|_| true));
    law.save_weights(&path).unwrap();
    let mut config = constants::config("analytic");
    let laws = config["laws"].as_array_mut().unwrap();
    laws.drain(..3);
    laws.insert(0, serde_json::to_value(NeuralConstantsSpec { weights: Some(path), ..spec(|_| true) }).unwrap());
    laws[0]["kind"] = json!("neural_constants");
    assert_eq!(WorldModel::weights(&*constants::build(&config)), law.weights(), "the file holds the weights");
    let names = constants::build(&config).constants();
    assert!(names.contains(&"laws.neural_constants.laws.viscosity.reach".to_owned()), "{names:?}");
    let written = constants::build(&constants::config("analytic")).constants();
    assert_eq!(names.len(), written.len());
    constants::check("neural_constants", &config);
    config["laws"][0]["width"] = json!(9);
    let refusal = serde_json::from_value::<ModelSpec>(config).unwrap().build().map(|_| ()).unwrap_err();
    assert!(format!("{refusal:#}").contains("edge.particle.first.weight"), "{refusal:#}");
}

#[test]
fn momentum_between_particles_is_kept() {
    let (scene, controls, _) = problem(&mut ChaCha8Rng::seed_from_u64(7));
    let total = |x: &Particles| x.velocities.iter().sum::<DVec3>();
    let speed: f64 = scene.particles.velocities.iter().map(|v| v.length()).sum();
    let end = |law: NeuralConstants| {
        let model = ParticleModel::new(40, 1.0, None, vec![Box::new(law)]).unwrap();
        model.rollout(&scene, &controls).pop().unwrap()
    };
    let (set, written) = (end(shaken(spec(|_| true))), end(spec(|_| true).build().unwrap()));
    let apart: f64 = set.velocities.iter().zip(&written.velocities).map(|(a, b)| a.distance(*b)).sum();
    assert!(apart > 0.01 * speed, "the network does nothing: {apart}");
    assert!(total(&set).distance(total(&scene.particles)) < 1e-12 * speed);
}

#[test]
fn a_pair_has_the_written_direction_and_a_constant_within_bounds_that_depends_on_its_surroundings() {
    let (mut scene, controls, _) = problem(&mut ChaCha8Rng::seed_from_u64(7));
    let far = DVec3::Z;
    let velocity = |law: NeuralConstants, positions: &[DVec3], scene: &mut Scene| {
        scene.particles = Particles::at_rest(positions.to_vec());
        scene.body = vec![0; positions.len()].into();
        let model = ParticleModel::new(1, 1.0, None, vec![Box::new(law)]).unwrap();
        model.rollout(scene, &controls[..1])[1].velocities[0]
    };
    let contact = || spec(|law| law == "contact");
    // A ring near enough to crowd the two, and too far to touch them.
    let pair = [far, far + 0.011 * DVec3::X];
    let ring = (0..6).map(|k| {
        let (sine, cosine) = f64::from(k).sin_cos();
        far + DVec3::new(0.0055, 0.0105 * cosine, 0.0105 * sine)
    });
    let crowded: Vec<DVec3> = pair.into_iter().chain(ring).collect();
    let written = velocity(contact().build().unwrap(), &pair, &mut scene);
    let [alone, among] = [&pair[..], &crowded].map(|p| velocity(shaken(contact()), p, &mut scene));
    for found in [alone, among] {
        assert!(found.cross(written).length() < 1e-12 * written.length_squared());
        let factor = found.dot(written) / written.length_squared();
        assert!(factor > (-BOUND).exp() && factor < BOUND.exp() && (factor - 1.0).abs() > 1e-2, "{factor}");
    }
    assert!(alone.distance(among) > 1e-3 * written.length(), "{alone} and {among}");
}

#[test]
fn untrained_it_is_exactly_its_written_laws_and_impossible_configs_are_refused() {
    let (scene, controls, _) = problem(&mut ChaCha8Rng::seed_from_u64(7));
    let untrained = among(spec(|_| true).build().unwrap());
    assert_eq!(untrained.rollout(&scene, &controls), analytic().rollout(&scene, &controls));
    let refused = |change: fn(&mut NeuralConstantsSpec)| {
        let mut spec = spec(|_| true);
        change(&mut spec);
        format!("{:#}", spec.build().map(|_| ()).expect_err("an impossible law"))
    };
    assert!(refused(|spec| spec.bound = 0.0).contains("bound"));
    assert!(refused(|spec| spec.speed = f64::NAN).contains("speed"));
    assert!(refused(|spec| spec.width = 0).contains("width"));
    assert!(refused(|spec| spec.laws.clear()).contains("laws"));
    let floor = refused(|spec| spec.laws.push(analytic_spec().laws.remove(3)));
    assert!(floor.contains("laws[3]") && floor.contains("\"floor\"") && floor.contains("dynamics.laws"), "{floor}");
    let inner = refused(|spec| {
        spec.laws = serde_json::from_value(json!([{"kind": "viscosity", "rate": -1.0, "reach": 0.1}])).unwrap()
    });
    assert!(inner.contains("laws[0]") && inner.contains("rate"), "{inner}");
}
