//! A rigid piece: one body, many particles that share its pose.
use super::SceneSpec;
use super::bodies::{self, Bodies};
use super::material::{Filling, Material, Matter};
use super::scale::inward;
use anyhow::Context;
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
        let corners = filling.lattice(scene.spacing, 0.0)?.corners;
        let points: Vec<Vector> = corners.into_iter().map(inward).collect();
        let collider = ColliderBuilder::convex_hull(&points).context("the region is too flat for a rigid piece")?;
        let mut bodies = Bodies::of(self.density);
        let collider = collider.friction(self.friction as Real).restitution(self.restitution as Real);
        bodies.add(physics, RigidBodyBuilder::dynamic(), collider, points);
        Ok(Matter::Bodies(bodies))
    }

    fn friction(&self) -> f64 {
        self.friction
    }

    fn settling(&self) -> f64 {
        0.5
    }
}
