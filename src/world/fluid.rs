//! Fluid: particles that keep their density.
use super::SceneSpec;
use super::liquid::Liquid;
use super::material::{Filling, Material, Matter, check};
use anyhow::ensure;
use glam::{DQuat, DVec3};
use rand_chacha::ChaCha8Rng;
use rapier3d::prelude::{IntegrationParameters, PhysicsWorld};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A liquid with a free surface; it slips along solids.
///
/// One step of it a physics step, `scene.solver.sweeps` sweeps each: choose `scene.solver.steps` so that a particle falls or
/// flows less than a quarter of `scene.spacing` in one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FluidSpec {
    /// Mass density ρ \[kg/m³\].
    #[schemars(range(min = 1.0, max = 20000.0))]
    pub density: f64,
    /// Share of the velocity difference to its neighbours that a particle loses in a physics step.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub viscosity: f64,
}

impl FluidSpec {
    /// Checks every number against its range.
    ///
    /// # Errors
    /// A sentence naming the key whose value is impossible.
    pub fn build(self) -> anyhow::Result<impl Material> {
        check(&[("density", self.density, 1.0, 2e4), ("viscosity", self.viscosity, 0.0, 1.0)])?;
        Ok(self)
    }
}

impl Material for FluidSpec {
    fn fill(
        &self,
        scene: &SceneSpec,
        filling: &Filling<'_>,
        _: &mut PhysicsWorld,
        _: &mut ChaCha8Rng,
    ) -> anyhow::Result<Matter> {
        let (spacing, (low, high)) = (scene.spacing, filling.bounds);
        let counts = ((high - low) / spacing).round().max(DVec3::ONE);
        ensure!(
            counts.element_product() <= 1e6,
            "a fluid of {} m at a spacing of {spacing} m takes more than a million particles: choose a larger scene.spacing",
            high - low
        );
        let start = (low + high - (counts - 1.0) * spacing) / 2.0;
        let [nx, ny, nz] = counts.to_array().map(|n| n as usize);
        let at = |i, j, k| start + spacing * DVec3::new(i as f64, j as f64, k as f64);
        let all = (0..nx).flat_map(|i| (0..ny).flat_map(move |j| (0..nz).map(move |k| (i, j, k))));
        let mut positions: Vec<DVec3> = all.map(|(i, j, k)| at(i, j, k)).filter(|p| (filling.contains)(*p)).collect();
        ensure!(
            !positions.is_empty(),
            "no particle {spacing} m apart fits into the fluid's start: choose a smaller scene.spacing"
        );
        let lowest = positions.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
        let (turn, rise) = (DQuat::from_rotation_z(filling.turn), filling.raised + spacing / 2.0 - lowest);
        positions.iter_mut().for_each(|p| *p = filling.at.extend(rise) + turn * *p);
        let velocities = vec![DVec3::ZERO; positions.len()];
        let (mass, sweeps) = (self.density * spacing.powi(3), scene.solver.sweeps);
        Ok(Matter::Liquid(Liquid { positions, velocities, spacing, mass, viscosity: self.viscosity, sweeps }))
    }

    fn friction(&self) -> f64 {
        0.0
    }

    /// The scene's sweeps are the fluid's own.
    fn tune(&self, _: &SceneSpec, _: &mut IntegrationParameters) {}

    fn settling(&self) -> f64 {
        0.0
    }
}
