//! The same tool whatever the goal.
use super::{Chooser, ChooserMaker, Lesson, Task};
use anyhow::ensure;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Config of [`Fixed`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FixedSpec {
    /// Name of the tool, one of the dataset's.
    pub tool: String,
}

impl FixedSpec {
    pub(crate) fn build(self) -> anyhow::Result<impl ChooserMaker> {
        Ok(self)
    }
}

impl ChooserMaker for FixedSpec {
    fn make(&self, lesson: &Lesson<'_>) -> anyhow::Result<Box<dyn Chooser>> {
        let known = || lesson.tools.keys().map(String::as_str).collect::<Vec<_>>().join(", ");
        ensure!(
            lesson.tools.contains_key(&self.tool),
            "chooser.tool is \"{}\", which planners do not have; choose from {}",
            self.tool,
            known()
        );
        Ok(Box::new(Fixed { tool: self.tool.clone() }))
    }
}

/// Plans the tool of one name.
#[derive(Debug)]
pub struct Fixed {
    tool: String,
}

impl Chooser for Fixed {
    fn shortlist(&self, task: &Task<'_>) -> Vec<usize> {
        task.tools.get_index_of(&self.tool).into_iter().collect()
    }
}
