//! The tool of every action is given.
use super::{Chooser, Task};
use anyhow::{Context, ensure};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Config of [`Ordered`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OrderedSpec {
    /// The tool of each action by its name among the dataset's; after the last one the first comes again.
    #[schemars(length(min = 1))]
    pub tools: Vec<String>,
}

impl OrderedSpec {
    pub(crate) fn build(self) -> anyhow::Result<Ordered> {
        ensure!(!self.tools.is_empty(), "chooser.tools is empty; name the tool of each action");
        Ok(Ordered { tools: self.tools })
    }
}

/// Plans one sequence: the tools that are next in its list.
#[derive(Clone, Debug)]
pub struct Ordered {
    tools: Vec<String>,
}

impl Ordered {
    /// The name of the tool that comes `later` actions after the task's.
    fn name(&self, task: &Task<'_>, later: usize) -> &str {
        &self.tools[(task.action as usize + later) % self.tools.len()]
    }
}

impl Chooser for Ordered {
    fn shortlist(&self, task: &Task<'_>) -> Vec<usize> {
        task.tools.get_index_of(self.name(task, 0)).into_iter().collect()
    }

    fn sequences(&self, task: &Task<'_>) -> anyhow::Result<Vec<Vec<usize>>> {
        let place = |later| {
            let name = self.name(task, later);
            task.tools.get_index_of(name).with_context(|| {
                let names = task.tools.keys().map(String::as_str).collect::<Vec<_>>().join(", ");
                format!("chooser.tools names \"{name}\", which planners do not have; choose from {names}")
            })
        };
        Ok(vec![(0..task.lookahead.max(1)).map(place).collect::<anyhow::Result<_>>()?])
    }
}
