//! The tools that a classifier thinks likely are planned.
use super::{Chooser, ChooserMaker, Lesson, Task};
use crate::config::{fingerprint, write_whole};
use crate::train::classifier::Classifier;
use crate::train::point_net::PointNetSpec;
use anyhow::ensure;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Config of [`Likely`]: a network from a workpiece and its goal to tools, learned from the training episodes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ClassifierSpec {
    /// Most tools that are planned, the most probable ones.
    #[schemars(range(min = 1))]
    pub top: usize,
    /// Probability below which a tool is not planned, unless it is the most probable one.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub above: f64,
    /// The network.
    #[serde(default)]
    pub network: PointNetSpec,
}

impl ClassifierSpec {
    pub(crate) fn build(self) -> anyhow::Result<impl ChooserMaker> {
        ensure!(self.top >= 1, "chooser.top must be at least 1");
        ensure!((0.0..=1.0).contains(&self.above), "chooser.above must lie in [0, 1], got {}", self.above);
        Ok(self)
    }
}

/// All that a classifier depends on: its folder is named by the fingerprint of this, which stands in it as `recipe.json`.
#[derive(Serialize)]
struct Recipe<'a> {
    dataset: String,
    network: &'a PointNetSpec,
}

impl ChooserMaker for ClassifierSpec {
    fn make(&self, lesson: &Lesson<'_>) -> anyhow::Result<Box<dyn Chooser>> {
        let recipe = Recipe { dataset: lesson.dataset.to_string(), network: &self.network };
        let folder = lesson.root.join("classifier").join(fingerprint(&recipe).to_string());
        write_whole(&folder.join("recipe.json"), &serde_json::to_vec_pretty(&recipe)?)?;
        let classifier = Classifier::fit(&self.network, lesson.data, &folder, lesson.watch)?;
        Ok(Box::new(Likely { classifier, folder, top: self.top, above: self.above }))
    }
}

/// Plans the tools that a classifier thinks most probable.
#[derive(Debug)]
pub struct Likely {
    classifier: Classifier,
    folder: PathBuf,
    top: usize,
    above: f64,
}

impl Chooser for Likely {
    fn shortlist(&self, task: &Task<'_>) -> Vec<usize> {
        let names = self.classifier.tools();
        let probabilities = self.classifier.probabilities(task.current, task.goal);
        let mut likely: Vec<(usize, f64)> = names
            .iter()
            .zip(probabilities)
            .filter_map(|(name, probability)| Some((task.tools.get_index_of(name)?, probability)))
            .collect();
        likely.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        let worth = likely.iter().take(self.top).enumerate().filter(|(rank, (_, p))| *rank == 0 || *p >= self.above);
        let mut shortlist: Vec<usize> = worth.map(|(_, (tool, _))| *tool).collect();
        shortlist.sort_unstable();
        shortlist
    }

    fn folder(&self) -> Option<&Path> {
        Some(&self.folder)
    }
}
