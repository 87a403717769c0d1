//! Every tool is planned.
use super::{Chooser, Task};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Config of [`Exhaustive`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ExhaustiveSpec {}

impl ExhaustiveSpec {
    pub(crate) fn build(self) -> anyhow::Result<Exhaustive> {
        Ok(Exhaustive)
    }
}

/// Plans every tool.
#[derive(Clone, Copy, Debug)]
pub struct Exhaustive;

impl Chooser for Exhaustive {
    fn shortlist(&self, task: &Task<'_>) -> Vec<usize> {
        (0..task.tools.len()).collect()
    }
}
