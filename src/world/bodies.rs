//! Rigid bodies of the engine, each with the particles that ride on it.
use super::material::{self, Substance};
use super::scale::{LENGTH, inward, length, outward};
use glam::DVec3;
use rapier3d::math::{Real, Vector};
use rapier3d::prelude::{ColliderBuilder, PhysicsWorld, RigidBodyBuilder, RigidBodyHandle};
use serde::{Deserialize, Serialize};

/// Deepest that a body may be in the table \[m\]; resting bodies are a quarter of it deep at most.
const SUNK: f64 = 2e-4;

/// Rigid bodies in a fixed order.
#[derive(Clone, Default, Serialize, Deserialize)]
pub struct Bodies {
    /// Each body, and its particles in its own frame in engine units.
    each: Vec<(RigidBodyHandle, Vec<Vector>)>,
    /// Their common density \[kg/m³\].
    density: f64,
}

impl Bodies {
    /// No bodies yet, of this density \[kg/m³\].
    pub(super) fn of(density: f64) -> Self {
        Self { each: Vec::new(), density }
    }

    /// Puts a dynamic `body` into the engine; `points` are its particles in its own frame in engine units.
    pub(super) fn add(
        &mut self,
        physics: &mut PhysicsWorld,
        body: RigidBodyBuilder,
        shape: ColliderBuilder,
        points: Vec<Vector>,
    ) {
        let body = body.can_sleep(false);
        self.each.push((physics.insert(body, shape.density(self.density as Real)).0, points));
    }
}

/// Checks the constants that every kind of rigid body has.
pub(super) fn check(density: f64, friction: f64, restitution: f64) -> anyhow::Result<()> {
    material::check(&[
        ("density", density, 1.0, 2e4),
        ("friction", friction, 0.0, 10.0),
        ("restitution", restitution, 0.0, 1.0),
    ])
}

impl Substance for Bodies {
    fn positions(&self, physics: &PhysicsWorld) -> Vec<DVec3> {
        let place = |(body, points): &(RigidBodyHandle, Vec<Vector>)| {
            let pose = *physics.bodies[*body].position();
            points.iter().map(move |p| outward(pose * *p)).collect::<Vec<_>>()
        };
        self.each.iter().flat_map(place).collect()
    }

    fn bodies(&self) -> Vec<usize> {
        self.each.iter().enumerate().flat_map(|(k, (_, points))| std::iter::repeat_n(k, points.len())).collect()
    }

    fn surface(&self, physics: &PhysicsWorld) -> Vec<DVec3> {
        self.positions(physics)
    }

    fn volume(&self, physics: &PhysicsWorld) -> f64 {
        let mass = |(body, _): &(RigidBodyHandle, Vec<Vector>)| f64::from(physics.bodies[*body].mass());
        self.each.iter().map(mass).sum::<f64>() / (self.density * LENGTH.powi(3))
    }

    fn kick(&mut self, velocity: &dyn Fn(DVec3) -> DVec3, physics: &mut PhysicsWorld) {
        for (body, _) in &self.each {
            let body = &mut physics.bodies[*body];
            body.set_linvel(body.linvel() + inward(velocity(outward(body.translation()))), true);
        }
    }

    fn shift(&mut self, by: &dyn Fn(DVec3) -> DVec3, physics: &mut PhysicsWorld) {
        for (body, _) in &self.each {
            let body = &mut physics.bodies[*body];
            let middle = body.translation();
            body.set_translation(middle + inward(by(outward(middle))), true);
        }
    }

    /// Contacts give way to a tool whose path is given, so that a body between it and the table would be driven through the table:
    /// one that is deeper in it than [`SUNK`] is put back onto it.
    fn mend(&mut self, physics: &mut PhysicsWorld, _: &[RigidBodyHandle]) {
        for (handle, _) in &self.each {
            let body = &mut physics.bodies[*handle];
            let lowest = body.colliders().iter().map(|&c| physics.colliders[c].compute_aabb().mins.z);
            let lowest = lowest.fold(Real::INFINITY, Real::min);
            if lowest < -length(SUNK) {
                body.set_translation(body.translation() - lowest * Vector::Z, true);
                let velocity = body.linvel();
                body.set_linvel(velocity.with_z(velocity.z.max(0.0)), true);
            }
        }
    }
}
