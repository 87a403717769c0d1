//! The gradient through velocity Verlet, by state, controls and constants.
use super::constants::{check as check_constants, config};
use super::*;
use pliant::model::particles::IntegratorSpec;
use serde_json::json;

fn of(name: &str) -> serde_json::Value {
    let mut config = config(name);
    config["integrator"] = json!("velocity_verlet");
    config
}

#[test]
fn the_gradient_through_velocity_verlet_agrees_with_central_differences() {
    for name in ["analytic", "formula"] {
        check(&*constants::build(&of(name)), &format!("{name} by Verlet"), |_| ());
        check_constants(&format!("{name} by Verlet"), &of(name));
    }
}

#[test]
fn a_held_acceleration_is_pulled_back_through_velocity_verlet() {
    check(&hybrid().integrated(IntegratorSpec::VelocityVerlet).unwrap(), "a hybrid by Verlet", |_| ());
}
