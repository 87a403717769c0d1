//! Random points of the box: what every search is measured by.
use super::{Each, Search, Start, Tried};
use crate::state::stream;
use rand::Rng;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Config of [`Random`], which has nothing to choose.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RandomSpec {}

impl RandomSpec {
    pub(crate) fn build(self) -> anyhow::Result<Random> {
        Ok(Random)
    }
}

/// The start, then points drawn evenly from the box.
pub struct Random;

/// Points between two looks at the clock.
const ROUND: usize = 16;

impl Search for Random {
    fn search(&self, start: &Start, tried: &Tried<'_>, each: &mut Each<'_>) -> anyhow::Result<()> {
        let mut rng = stream(start.seed, &[u64::from_le_bytes(*b"random  ")]);
        let mut left = start.evaluations;
        let mut points = vec![start.point.clone()];
        while left > 0 {
            points.truncate(left);
            left -= points.len();
            points.par_iter().for_each(|point| {
                tried.cost(point);
            });
            each(None)?;
            points = (0..ROUND).map(|_| start.point.iter().map(|_| rng.random()).collect()).collect();
        }
        Ok(())
    }
}
