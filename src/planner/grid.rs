//! A grid over the box, as RoboCook (Shi et al. 2023) searches small ones.
use super::Sampler;
use anyhow::ensure;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Config of [`Grid`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GridSpec {
    /// Most plans: the grid is the finest with equally many points along each axis that has no more.
    #[schemars(range(min = 1))]
    pub samples: usize,
}

/// Costs the middles of n^d equal cells, n the greatest number with n^d ≤ `samples`, in random order, so that a budget which
/// ends early has covered the whole box.
#[derive(Clone, Debug)]
pub struct Grid {
    samples: usize,
}

impl GridSpec {
    pub(crate) fn build(self) -> anyhow::Result<Grid> {
        ensure!(self.samples >= 1, "planner.samples must be at least 1");
        Ok(Grid { samples: self.samples })
    }
}

impl Sampler for Grid {
    /// Number of coordinates.
    type Params = usize;

    fn init(&self, dimension: usize) -> usize {
        dimension
    }

    fn sample(&self, dimension: &usize, _: usize, rng: &mut ChaCha8Rng) -> Vec<Vec<f64>> {
        let fits = |n: &usize| n.checked_pow(*dimension as u32).is_some_and(|count| count <= self.samples);
        let n = (1..=self.samples).take_while(fits).last().unwrap_or(1);
        let cell = |k: usize, axis: usize| ((k / n.pow(axis as u32) % n) as f64 + 0.5) / n as f64;
        let mut plans: Vec<Vec<f64>> =
            (0..n.pow(*dimension as u32)).map(|k| (0..*dimension).map(|axis| cell(k, axis)).collect()).collect();
        plans.shuffle(rng);
        plans
    }

    fn update(&self, dimension: usize, _: &[Vec<f64>], _: &[f64]) -> usize {
        dimension
    }

    fn done(&self, least: &[f64]) -> bool {
        !least.is_empty()
    }
}
