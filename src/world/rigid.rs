//! A rigid piece: one body, many particles that share its pose.
use super::SceneSpec;
use super::bodies::{self, Bodies};
use super::lattice::Lattice;
use super::material::{Filling, Material, Matter};
use super::scale::inward;
use anyhow::Context;
use glam::{DQuat, DVec3};
use rand_chacha::ChaCha8Rng;
use rapier3d::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A convex rigid piece: the hull of the lattice that fills the region, whose corners are its particles.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RigidSpec {
    /// Mass density \[kg/m³\].
    #[schemars(range(min = 1.0, max = 20000.0))]
    pub density: f64,
    /// Coulomb friction coefficient against table and tools.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub friction: f64,
    /// Newton's coefficient of restitution.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub restitution: f64,
}

impl RigidSpec {
    /// Checks every number against its range.
    ///
    /// # Errors
    /// A sentence naming the key whose value is impossible.
    pub fn build(self) -> anyhow::Result<impl Material> {
        bodies::check(self.density, self.friction, self.restitution)?;
        Ok(self)
    }
}

impl Material for RigidSpec {
    fn fill(
        &self,
        scene: &SceneSpec,
        filling: &Filling<'_>,
        physics: &mut PhysicsWorld,
        _: &mut ChaCha8Rng,
    ) -> anyhow::Result<Matter> {
        let lattice = Lattice::fill(filling.contains, filling.bounds, scene.spacing)?;
        let lowest = lattice.corners.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
        let (turn, rise) = (DQuat::from_rotation_z(filling.turn), (filling.raised - lowest) * DVec3::Z);
        let points: Vec<Vector> = lattice.corners.iter().map(|p| inward(turn * *p + rise)).collect();
        let collider = ColliderBuilder::convex_hull(&points).context("the region is too flat for a rigid piece")?;
        let collider = collider.density(self.density as Real).friction(self.friction as Real);
        let collider = collider.restitution(self.restitution as Real);
        let body = physics.insert(RigidBodyBuilder::dynamic().can_sleep(false), collider).0;
        Ok(Matter::Bodies(Bodies { each: vec![(body, points)], density: self.density }))
    }

    fn friction(&self) -> f64 {
        self.friction
    }

    fn tune(&self, scene: &SceneSpec, parameters: &mut IntegrationParameters) {
        parameters.num_internal_pgs_iterations = scene.solver.sweeps;
    }

    fn settling(&self) -> f64 {
        0.5
    }
}
