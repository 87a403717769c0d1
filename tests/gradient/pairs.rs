//! The learned law of every substep: exact derivatives, momentum, and its start.
use super::*;
use pliant::model::law::{LearnedPair, LearnedPairSpec};
use rand::Rng;

fn spec() -> LearnedPairSpec {
    let text = "width = 8\nedges = [\"particle\", \"tool\", \"floor\"]\nradius = 0.016\nskin = 0.006\nstrength = 1.0\nspeed = 0.05\nseed = 3";
    toml_edit::de::from_str(text).unwrap()
}

/// Shaken out of its zero start by multiples of 1/64, which f32 holds exactly.
fn shaken(edges: &[&str]) -> LearnedPair {
    let mut law = LearnedPairSpec { edges: edges.iter().map(|e| (*e).to_owned()).collect(), ..spec() }.build().unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let weights: Vec<f32> =
        law.weights().iter().map(|w| ((w + rng.random_range(-0.4..0.4)) * 64.0).round() / 64.0).collect();
    law.set_weights(&weights);
    law
}

fn residual(law: LearnedPair) -> ParticleModel {
    let mut laws = analytic_laws();
    laws.push(Box::new(law));
    ParticleModel::new(40, 0.01, None, laws).unwrap()
}

#[test]
fn the_gradient_through_a_law_learned_in_every_substep_agrees_with_central_differences() {
    for edges in [&["particle"][..], &["tool"], &["floor"], &["particle", "tool", "floor"]] {
        check(&residual(shaken(edges)), &format!("{edges:?}"), |_| ());
    }
    check(&residual(shaken(&["floor", "particle"])), "beside a wall", beside_a_wall);
}

#[test]
fn its_weight_gradient_agrees_with_central_differences() {
    let problem = problem(&mut ChaCha8Rng::seed_from_u64(11));
    let mut model = residual(shaken(&["particle", "tool", "floor"]));
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
        assert!(difference.abs() > 1e-3, "the weights do nothing: {difference}");
        assert!((exact - difference).abs() <= 1e-4 * difference.abs().max(0.1), "{exact} against {difference}");
    }
}

#[test]
fn momentum_between_particles_is_kept_and_tool_and_floor_are_free() {
    let (mut scene, controls, _) = problem(&mut ChaCha8Rng::seed_from_u64(7));
    let total = |x: &Particles| x.velocities.iter().sum::<DVec3>();
    let speed: f64 = scene.particles.velocities.iter().map(|v| v.length()).sum();
    let lost = |scene: &Scene, law: LearnedPair| {
        let model = ParticleModel::new(40, 1.0, None, vec![Box::new(law)]).unwrap();
        let rollout = model.rollout(scene, &controls);
        let moved = rollout[STEPS].velocities.iter().zip(&rollout[0].velocities);
        let moved: f64 = moved.map(|(a, b)| a.distance(*b)).sum();
        assert!(moved > 0.01 * speed, "the law does nothing: {moved}");
        total(&rollout[STEPS]).distance(total(&rollout[0])) / speed
    };
    assert!(lost(&scene, shaken(&["particle"])) < 1e-12);
    assert!(lost(&scene, shaken(&["tool"])) > 1e-3);
    assert!(lost(&scene, shaken(&["floor"])) > 1e-3);
    // Far from tool and table all three together keep it too.
    scene.particles.positions.iter_mut().for_each(|x| x.z += 1.0);
    assert!(lost(&scene, shaken(&["particle", "tool", "floor"])) < 1e-12);
}

#[test]
fn untrained_it_adds_exactly_nothing_and_impossible_configs_are_refused() {
    let (scene, controls, _) = problem(&mut ChaCha8Rng::seed_from_u64(7));
    let untrained = residual(spec().build().unwrap());
    assert_eq!(untrained.rollout(&scene, &controls), analytic().rollout(&scene, &controls));
    let refused = |spec: LearnedPairSpec| spec.build().expect_err("an impossible law").to_string();
    assert!(refused(LearnedPairSpec { skin: 0.0, ..spec() }).contains("skin"));
    assert!(refused(LearnedPairSpec { width: 0, ..spec() }).contains("width"));
    let edges = vec!["particle".to_owned(), "bond".to_owned()];
    assert!(refused(LearnedPairSpec { edges, ..spec() }).contains("bond"));
    let twice = vec!["tool".to_owned(); 2];
    assert!(refused(LearnedPairSpec { edges: twice, ..spec() }).contains("twice"));
}

#[test]
fn its_weights_come_back_from_a_file_that_fits() {
    let (folder, law) = (tempfile::tempdir().unwrap(), shaken(&["particle", "floor"]));
    let path = folder.path().join("weights.safetensors");
    law.save_weights(&path).unwrap();
    let read = |edges: &[&str], width: usize| {
        let edges = edges.iter().map(|e| (*e).to_owned()).collect();
        LearnedPairSpec { edges, width, weights: Some(path.clone()), ..spec() }.build()
    };
    assert_eq!(read(&["particle", "floor"], 8).unwrap().weights(), law.weights());
    let refusal = format!("{:#}", read(&["particle", "floor"], 9).unwrap_err());
    assert!(refusal.contains("edge.particle.first.weight") && refusal.contains("weights.safetensors"), "{refusal}");
    assert!(read(&["particle"], 8).is_err());
}
