//! The substep follows the stiffest law.
use super::*;
use pliant::model::Dynamics;
use pliant::train::replace;
use serde_json::{Value, json};

fn bonded() -> Value {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/configs/model/bonds.toml");
    let contender = toml_edit::de::from_str::<Contender>(&std::fs::read_to_string(path).unwrap()).unwrap();
    let mut config = serde_json::to_value(contender.dynamics).unwrap();
    for law in config["laws"].as_array_mut().unwrap().iter_mut().filter(|law| law.get("slip").is_some()) {
        law["tangential_stiffness"] = json!(10.0);
    }
    (config["substeps"], config["stability"]) = (json!(1), json!(1.0));
    config
}

fn particle_model(config: &Value) -> ParticleModel {
    let ModelSpec::Particles(spec) = serde_json::from_value(config.clone()).unwrap() else {
        panic!("no particle model")
    };
    let laws = spec.laws.into_iter().map(|law| law.build().unwrap()).collect();
    ParticleModel::new(spec.substeps, spec.keep, None, laws).unwrap().stable(spec.stability).unwrap()
}

#[test]
fn the_substep_follows_whichever_law_is_the_stiffest() {
    let config = bonded();
    let substeps = |changes: &[(&str, f64)]| {
        let config = replace(&config, changes.iter().copied()).unwrap();
        particle_model(&config).substeps(0.1) as f64
    };
    for (path, power) in [
        ("laws.contact.stiffness", 0.5),
        ("laws.contact.tangential_stiffness", 0.5),
        ("laws.bonds.stiffness", 0.5),
        ("laws.bonds.damping", 1.0),
        ("laws.viscosity.rate", 1.0),
        ("laws.floor.stiffness", 0.5),
        ("laws.tool.stiffness", 0.5),
    ] {
        let [one, four] = [1e7, 4e7].map(|stiffness| substeps(&[(path, stiffness)]));
        assert!(one > 2.0 * substeps(&[]), "{path} is the stiffest by far");
        assert!((four / one / 4.0_f64.powf(power) - 1.0).abs() < 0.01, "{path}: {one} and {four}");
    }
    let mut fixed = config.clone();
    fixed.as_object_mut().unwrap().remove("stability");
    assert_eq!(particle_model(&fixed).substeps(0.1), 1);
    fixed["substeps"] = json!(5000);
    fixed["stability"] = json!(1.0);
    assert_eq!(particle_model(&fixed).substeps(0.1), 5000, "substeps are the least");
}

#[test]
fn stiff_bonds_fly_apart_in_long_substeps_and_hold_in_stable_ones() {
    let mut config = replace(&bonded(), [("laws.bonds.stiffness", 1e5), ("laws.bonds.breaking_strain", 1e9)]).unwrap();
    config["keep"] = json!(1.0);
    config["laws"].as_array_mut().unwrap().retain(|law| law["kind"] == "bonds");
    config["laws"][0]["yield_strain"] = json!(null);
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let positions = block();
    let particles = Particles { velocities: positions.iter().map(|_| 0.01 * vector(&mut rng)).collect(), positions };
    let (start, controls) = alone(particles, 10);
    let energy = |x: &Particles| x.velocities.iter().map(|v| v.length_squared()).sum::<f64>();
    let grows = |config: &Value| {
        let rollout =
            serde_json::from_value::<ModelSpec>(config.clone()).unwrap().build().unwrap().rollout(&start, &controls);
        let most = rollout.iter().map(energy).fold(0.0, |a: f64, b| if b.is_nan() { f64::INFINITY } else { a.max(b) });
        most / energy(&rollout[0])
    };
    assert!(grows(&config) < 1.1, "{}", grows(&config));
    config["stability"] = json!(null);
    config["substeps"] = json!(20);
    assert!(grows(&config) > 10.0);
}

#[test]
fn a_law_that_needs_too_many_substeps_is_refused() {
    let config = replace(&bonded(), [("laws.bonds.stiffness", 1e15)]).unwrap();
    let (start, _) = alone(Particles::at_rest(block()), 0);
    let refusal = Dynamics::accepts(&particle_model(&config), &start).unwrap_err().to_string();
    assert!(refusal.contains("too stiff") && refusal.contains("dynamics.stability"), "{refusal}");
}
