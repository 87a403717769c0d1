//! Gradients through contact, plastic flow and friction.
use super::agreement::check;
use super::*;
use pliant::state::Wall;

#[test]
fn the_gradient_agrees_with_central_differences_as_shipped() {
    check(&model(shipped()), "mpm", |_| ());
}

#[test]
fn the_gradient_agrees_through_flow_friction_and_walls() {
    // Heavy, so that sound is slow and substeps are few.
    let dough = MpmSpec { density: 1.2e4, yield_stress: 30.0, viscosity: 1.0, gravity: 2.0, ..elastic() };
    check(&model(dough.clone()), "dough by a wall", |scene| {
        scene.walls = [Wall { normal: DVec3::new(-0.8, 0.0, 0.6), offset: -0.01 }].into();
    });
    check(&model(MpmSpec { tool: SurfaceSpec::Sticky {}, table: SurfaceSpec::Sticky {}, ..dough }), "sticky", |_| ());
}
