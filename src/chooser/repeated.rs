//! Every tool is planned, and none changed while looking ahead.
use super::{Chooser, Task};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Config of [`Repeated`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RepeatedSpec {}

impl RepeatedSpec {
    pub(crate) fn build(self) -> anyhow::Result<Repeated> {
        Ok(Repeated)
    }
}

/// Plans as many sequences as there are tools, each of one tool alone.
#[derive(Clone, Copy, Debug)]
pub struct Repeated;

impl Chooser for Repeated {
    fn shortlist(&self, task: &Task<'_>) -> Vec<usize> {
        (0..task.tools.len()).collect()
    }

    fn sequences(&self, task: &Task<'_>) -> anyhow::Result<Vec<Vec<usize>>> {
        Ok(self.shortlist(task).into_iter().map(|place| vec![place; task.lookahead.max(1)]).collect())
    }
}
