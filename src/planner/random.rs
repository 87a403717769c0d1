//! Random shooting: the cheapest of uniform draws.
use super::Sampler;
use anyhow::ensure;
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Config of [`Random`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RandomSpec {
    /// Plans, the middle of the box among them.
    #[schemars(range(min = 1))]
    pub samples: usize,
}

/// Costs the middle of the box and uniform draws in one round, and keeps the cheapest.
#[derive(Clone, Debug)]
pub struct Random {
    samples: usize,
}

impl RandomSpec {
    pub(crate) fn build(self) -> anyhow::Result<Random> {
        ensure!(self.samples >= 1, "planner.samples must be at least 1");
        Ok(Random { samples: self.samples })
    }
}

impl Sampler for Random {
    /// Number of coordinates.
    type Params = usize;

    fn init(&self, dimension: usize) -> usize {
        dimension
    }

    fn sample(&self, dimension: &usize, _: usize, rng: &mut ChaCha8Rng) -> Vec<Vec<f64>> {
        let draw = |_| (0..*dimension).map(|_| rng.random()).collect();
        std::iter::once(vec![0.5; *dimension]).chain((1..self.samples).map(draw)).collect()
    }

    fn update(&self, dimension: usize, _: &[Vec<f64>], _: &[f64]) -> usize {
        dimension
    }

    fn done(&self, least: &[f64]) -> bool {
        !least.is_empty()
    }
}
