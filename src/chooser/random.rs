//! One tool, drawn: the floor of every choice.
use super::{Chooser, Task};
use crate::state::stream;
use rand::Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Config of [`Random`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RandomSpec {}

impl RandomSpec {
    pub(crate) fn build(self) -> anyhow::Result<Random> {
        Ok(Random)
    }
}

/// Plans one tool, drawn by the seed and the action's number alone: every model is given the same.
#[derive(Clone, Copy, Debug)]
pub struct Random;

/// First word of every stream that tools are drawn from.
const CHOOSING: u64 = u64::from_le_bytes(*b"choosing");

impl Chooser for Random {
    fn shortlist(&self, task: &Task<'_>) -> Vec<usize> {
        let drawn = |count| stream(task.seed, &[CHOOSING, task.action]).random_range(0..count);
        (!task.tools.is_empty()).then(|| drawn(task.tools.len())).into_iter().collect()
    }
}
