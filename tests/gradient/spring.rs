//! The gradient through friction with a tangential spring, sticking and sliding.
use super::agreement::{Change, check_at};
use super::constants::{build, check as check_constants, config};
use super::*;
use pliant::train::replace;
use serde_json::{Value, json};

/// The analytical dough whose friction remembers.
fn sprung(friction: f64) -> Value {
    let mut config = config("analytic");
    for law in config["laws"].as_array_mut().unwrap() {
        if law.get("friction").is_some() {
            law["tangential_stiffness"] = json!(500.0);
            law["friction"] = json!(friction);
        }
    }
    config
}

/// Whatever starts or stops to slide within a step bends the cost there, and a lump of springs does so often: steps are shorter.
fn check_sprung(config: &Value, name: &str, change: Change) {
    check_at(&*build(config), name, change, [4e-10, 1e-10, 3e-11], 1e-5);
}

#[test]
fn the_gradient_through_springs_that_stick_and_slide_agrees_with_central_differences() {
    for (friction, integrator) in [(0.1, "semi_implicit_euler"), (0.3, "velocity_verlet"), (3.0, "semi_implicit_euler")]
    {
        let mut config = sprung(friction);
        config["integrator"] = json!(integrator);
        check_sprung(&config, &format!("friction {friction} by {integrator}"), |_| ());
    }
    check_sprung(&sprung(0.3), "springs beside a wall", beside_a_wall);
}

#[test]
fn derivatives_by_the_constants_of_springs_agree_with_central_differences() {
    check_constants("springs", &sprung(0.3));
    let names = build(&sprung(0.3)).constants();
    assert_eq!(names.iter().filter(|name| name.ends_with("tangential_stiffness")).count(), 3);
}

#[test]
fn springs_stick_and_slide_in_what_was_differentiated() {
    let (scene, controls, cost) = problem(&mut ChaCha8Rng::seed_from_u64(7));
    let total = |friction: f64, stiffness: f64| {
        let changes = ["contact", "floor", "tool"].map(|law| (format!("laws.{law}.tangential_stiffness"), stiffness));
        let config = replace(&sprung(friction), changes.iter().map(|(path, k)| (path.as_str(), *k))).unwrap();
        cost.total(&build(&config).rollout(&scene, &controls))
    };
    let change = |a: f64, b: f64| (a / b - 1.0).abs();
    assert!(change(total(3.0, 500.0), total(3.0, 200.0)) > 1e-4, "nothing sticks");
    assert!(change(total(0.1, 500.0), total(0.12, 500.0)) > 1e-4, "nothing slides");
}
