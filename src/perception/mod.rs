//! Perception: what was observed becomes particles.
use crate::shape::Filled;
use crate::state::Particles;
use glam::DVec3;
use rand_chacha::ChaCha8Rng;

mod clean;
mod cloud;
mod table;
mod truth;

pub use cloud::{Cloud, CloudSpec};
pub use table::Plane;
pub use truth::{Truth, TruthSpec};

/// What the world shows.
#[derive(Clone, Debug, PartialEq)]
pub enum Observation {
    /// The true particles.
    Particles(Particles),
    /// Points that cameras saw, the table among them or not, z up \[m\].
    Cloud(Vec<DVec3>),
}

/// Turns an observation into particles standing on the table z = 0.
pub trait Perception: Send + Sync {
    /// `count` particles at rest or as observed.
    ///
    /// # Errors
    /// When this perception cannot use that kind of observation, or finds no object in it.
    fn perceive(&self, observation: &Observation, count: usize, rng: &mut ChaCha8Rng) -> anyhow::Result<Particles>;

    /// The volume that the observed object fills, for whoever rebuilds it.
    ///
    /// # Errors
    /// As [`Perception::perceive`]; also when this perception knows particles but no volume.
    fn region(&self, observation: &Observation) -> anyhow::Result<Filled>;
}

family! {
    /// The perceptions that a config can name.
    PerceptionSpec builds Box<dyn Perception> {
        Truth(TruthSpec),
        Cloud(CloudSpec),
    }
}
