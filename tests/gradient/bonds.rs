//! The gradient through bonds that flow and break, by state, controls and constants.
use super::constants::{build, check as check_constants, config};
use super::*;
use pliant::train::replace;
use serde_json::{Value, json};

/// Bonds so brittle that some break within a few steps.
fn brittle() -> Value {
    replace(&config("bonds"), [("laws.bonds.breaking_strain", 0.1)]).unwrap()
}

#[test]
fn the_gradient_through_bonds_agrees_with_central_differences() {
    for integrator in ["semi_implicit_euler", "velocity_verlet"] {
        let mut config = brittle();
        config["integrator"] = json!(integrator);
        check(&*build(&config), &format!("bonds by {integrator}"), |_| ());
    }
}

#[test]
fn derivatives_by_the_constants_of_bonds_agree_with_central_differences() {
    check_constants("bonds", &brittle());
    let names = build(&brittle()).constants();
    let of_bonds: Vec<&str> = names.iter().filter_map(|path| path.strip_prefix("laws.bonds.")).collect();
    assert_eq!(of_bonds, ["stiffness", "damping", "yield_strain"], "where a bond breaks is a switch");
}

#[test]
fn bonds_flow_and_break_in_what_was_differentiated() {
    let (scene, controls, cost) = problem(&mut ChaCha8Rng::seed_from_u64(7));
    let end = |changes: &[(&str, f64)]| {
        let config = replace(&brittle(), changes.iter().copied()).unwrap();
        cost.total(&build(&config).rollout(&scene, &controls))
    };
    let whole = end(&[]);
    for change in [("laws.bonds.yield_strain", 0.9), ("laws.bonds.breaking_strain", 9.0)] {
        assert!((end(&[change]) - whole).abs() > 1e-6 * whole.abs(), "{} does nothing here", change.0);
    }
}
