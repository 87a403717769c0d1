//! Ground truth, passed through.
use super::{Observation, Perception};
use crate::shape::Filled;
use crate::state::Particles;
use anyhow::{bail, ensure};
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Config of [`Truth`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TruthSpec {}

impl TruthSpec {
    pub(crate) fn build(self) -> anyhow::Result<Truth> {
        Ok(Truth)
    }
}

/// Sees the true particles.
#[derive(Clone, Copy, Debug)]
pub struct Truth;

impl Perception for Truth {
    fn perceive(&self, observation: &Observation, count: usize, _: &mut ChaCha8Rng) -> anyhow::Result<Particles> {
        let Observation::Particles(particles) = observation else {
            bail!("a cloud has no true particles; choose perception \"cloud\"");
        };
        ensure!(
            particles.len() == count,
            "the world shows {} particles but {count} are asked for; make the two numbers equal",
            particles.len()
        );
        Ok(particles.clone())
    }

    fn region(&self, _: &Observation) -> anyhow::Result<Filled> {
        bail!("true particles have no volume to rebuild; choose perception \"cloud\"")
    }
}
