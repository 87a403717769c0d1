//! Dough in physical numbers, and what they are called inside the engine.
use super::scale::LENGTH;
use rapier3d::prelude::{Real, SoftBodyMaterial, SpringCoefficients};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// An elastic, plastic solid: it springs back below its yield strain and keeps what exceeds it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DoughSpec {
    /// Mass density ρ \[kg/m³\].
    #[schemars(range(min = 1.0, max = 20000.0))]
    pub density: f64,
    /// Young's modulus E \[Pa\].
    #[schemars(range(min = 100.0, max = 1e7))]
    pub young_modulus: f64,
    /// Poisson's ratio ν; 0.5 would be incompressible.
    #[schemars(range(min = 0.0, max = 0.4999))]
    pub poisson_ratio: f64,
    /// Damping ratio of the elastic vibrations, 1 being critical.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub damping_ratio: f64,
    /// Strain beyond which deformation stays; 0 makes the material purely elastic.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub yield_strain: f64,
    /// Rate at which strain beyond the yield becomes permanent \[1/s\].
    #[schemars(range(min = 0.0, max = 1e6))]
    pub creep_rate: f64,
    /// Largest permanent strain along any direction, which keeps crushed dough from flowing to nothing.
    #[schemars(range(min = 0.0, max = 0.95))]
    pub largest_set: f64,
    /// Coulomb friction coefficient against table and tools.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub friction: f64,
}

impl DoughSpec {
    /// The engine's springs on a lattice of the given spacing \[m\].
    ///
    /// The engine asks for natural frequencies, which no scaling of lengths changes. An edge of length s between masses ρ s³
    /// has stiffness E s, hence ω = √(2E/ρ)/s; a cell resists compression with the bulk modulus K = E / (3 (1 − 2ν)), hence
    /// ω = √(K/ρ)/s. A lattice twice as fine is so twice as fast and as stiff.
    pub(super) fn springs(&self, spacing: f64) -> SoftBodyMaterial {
        let bulk = self.young_modulus / (3.0 * (1.0 - 2.0 * self.poisson_ratio));
        let spring = |modulus: f64| {
            let frequency = (modulus / self.density).sqrt() / (TAU * spacing);
            SpringCoefficients::new(frequency as Real, self.damping_ratio as Real)
        };
        SoftBodyMaterial {
            volume_softness: spring(bulk),
            edge_plastic_yield: self.yield_strain as Real,
            edge_plastic_creep: self.creep_rate as Real,
            edge_plastic_max: self.largest_set as Real,
            ..SoftBodyMaterial::uniform(spring(2.0 * self.young_modulus))
        }
    }

    /// Mass of a volume \[m³\] in the engine's units.
    pub(super) fn mass(&self, volume: f64) -> Real {
        (self.density * volume * LENGTH.powi(3)) as Real
    }
}
