//! A folder of episodes made from one spec.
use super::contents::Contents;
use super::vary::{self, Ranges};
use super::{Episode, Metadata, SplitSpec};
use crate::state::{Constants, ToolShape};
use crate::tool::ToolSpec;
use crate::world::{MaterialSpec, SceneSpec, StartSpec};
use anyhow::{Context, ensure};
use indexmap::IndexMap;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Random actions of some tools in one kind of scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DatasetSpec {
    /// Number of episodes.
    #[schemars(range(min = 1, max = 1_000_000))]
    pub episodes: usize,
    /// Seed of all starts and actions.
    pub seed: u64,
    /// Control steps of an episode.
    #[serde(default = "steps")]
    #[schemars(range(min = 3, max = 1000))]
    pub steps: usize,
    /// Greatest number of unrecorded random actions before the recorded one, so that deformed starts occur too.
    #[serde(default = "before")]
    #[schemars(range(min = 0, max = 10))]
    pub before: usize,
    /// What the tools act on.
    pub scene: SceneSpec,
    /// The tools by name; episode k uses number k modulo their count.
    pub tool: IndexMap<String, ToolSpec>,
    /// Materials by name that take the place of the scene's, one an episode, each with every tool; planning keeps the scene's.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub material: IndexMap<String, MaterialSpec>,
    /// Starts by name that take the place of the scene's, one an episode, each with every tool and material.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub start: IndexMap<String, StartSpec>,
    /// Constants of the scene that every episode draws for itself, by their path in it; they come after materials and starts.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub vary: Ranges,
    /// Which episodes are held out; changing it keeps the episodes of a folder.
    #[serde(default, skip_serializing_if = "SplitSpec::is_default")]
    pub split: SplitSpec,
}

fn steps() -> usize {
    15
}

fn before() -> usize {
    2
}

impl DatasetSpec {
    /// Name of the tool of episode `k`.
    pub(super) fn tool_of(&self, k: usize) -> &str {
        self.tool.get_index(k % self.tool.len()).expect("a number below their count").0
    }

    /// Material of episode `k`, where several are listed.
    pub(super) fn material_of(&self, k: usize) -> Option<(&str, &MaterialSpec)> {
        turn(&self.material, k / self.tool.len())
    }

    /// Start of episode `k`, where several are listed.
    pub(super) fn start_of(&self, k: usize) -> Option<(&str, &StartSpec)> {
        turn(&self.start, k / (self.tool.len() * self.material.len().max(1)))
    }

    /// Number of episodes after which every tool has met every material and start.
    pub(super) fn combinations(&self) -> usize {
        self.tool.len() * self.material.len().max(1) * self.start.len().max(1)
    }

    /// The scene of episode `k` with its material and start, before [`vary`] changes it.
    fn listed(&self, k: usize) -> SceneSpec {
        let mut scene = self.scene.clone();
        if let Some((_, material)) = self.material_of(k) {
            scene.material = material.clone();
        }
        if let Some((_, start)) = self.start_of(k) {
            scene.start = start.clone();
        }
        scene
    }

    /// The scene of episode `k`.
    ///
    /// # Errors
    /// When a constant of `vary` is none of this scene.
    pub fn scene_of(&self, k: usize) -> anyhow::Result<SceneSpec> {
        vary::with(self.listed(k), &self.constants_of(k))
    }

    /// What [`DatasetSpec::vary`] draws for episode `k`.
    pub fn constants_of(&self, k: usize) -> Constants {
        vary::drawn(&self.vary, self.seed, k)
    }

    /// What the scene itself has in the places that [`DatasetSpec::vary`] draws for: the constants of the world that is planned in.
    pub fn constants(&self) -> Constants {
        vary::own(&self.vary, &self.scene)
    }

    /// Refuses what no dataset can be made of.
    ///
    /// # Errors
    /// A sentence naming the key.
    pub(super) fn check(&self) -> anyhow::Result<()> {
        ensure!(self.episodes > 0, "`episodes` is 0; a dataset needs at least one");
        ensure!(self.steps >= 3, "`steps` is {}; a tool needs three to come, work and leave", self.steps);
        ensure!(!self.tool.is_empty(), "`tool` is empty; name at least one tool");
        for k in 0..self.combinations().min(self.episodes) {
            vary::check(&self.vary, &self.listed(k))?;
        }
        self.split.clone().build()?.check(self)
    }
}

/// Number `k` modulo their count of some named things; `None` of nothing.
fn turn<T>(things: &IndexMap<String, T>, k: usize) -> Option<(&str, &T)> {
    things.get_index(k % things.len().max(1)).map(|(name, thing)| (&name[..], thing))
}

/// Episodes in memory, and the shapes of the tools that made them.
#[derive(Clone, Debug)]
pub struct Dataset {
    /// Episodes in order.
    pub episodes: Vec<Episode>,
    /// Shape of each tool, by name.
    pub tools: IndexMap<String, Arc<ToolShape>>,
    /// What the folder says of itself.
    pub metadata: Metadata,
}

impl Dataset {
    /// Reads a folder that [`super::simulate`] has finished.
    ///
    /// # Errors
    /// When the folder or one of its files is missing, unfinished or damaged: a sentence with the file and the fix.
    pub fn load(folder: &Path) -> anyhow::Result<Self> {
        let contents = Contents::read(folder)?;
        let episodes = contents.attempt(folder).into_iter().collect::<anyhow::Result<_>>()?;
        Ok(Self { episodes, tools: contents.tools(folder)?, metadata: contents.metadata })
    }
}

/// The resolved spec, beside the episodes.
pub(super) const SPEC: &str = "dataset.toml";

/// Where episode `k` lies.
pub(super) fn episode_path(folder: &Path, k: usize) -> PathBuf {
    folder.join(format!("episode_{k:05}.npz"))
}

/// The spec that a folder was made from, or `None` where there is none yet.
pub(super) fn read_spec(folder: &Path) -> anyhow::Result<Option<DatasetSpec>> {
    let path = folder.join(SPEC);
    let text = match std::fs::read_to_string(&path) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        read => read.with_context(|| format!("cannot read {}", path.display()))?,
    };
    let spec: DatasetSpec = toml_edit::de::from_str(&text)
        .with_context(|| format!("{} is not a dataset's spec; remove the folder and simulate again", path.display()))?;
    spec.check().with_context(|| format!("in {}", path.display()))?;
    Ok(Some(spec))
}

/// All episodes of a finished folder, in order.
pub(super) fn read_episodes(folder: &Path, spec: &DatasetSpec) -> anyhow::Result<Vec<Episode>> {
    let read = |k| {
        let episode = read_episode(&episode_path(folder, k), spec.tool_of(k), spec.steps)?;
        Ok(Episode { constants: spec.constants_of(k).into(), ..episode })
    };
    (0..spec.episodes).into_par_iter().map(read).collect()
}

/// The episode at `path`, made with `tool` in `steps` steps.
///
/// # Errors
/// As [`Episode::read`]; also when it has another number of steps.
pub(super) fn read_episode(path: &Path, tool: &str, steps: usize) -> anyhow::Result<Episode> {
    let episode = Episode::read(path, tool)?;
    let horizon = episode.horizon();
    ensure!(horizon == steps, "{} has {horizon} steps, not {steps}; remove it and simulate again", path.display());
    Ok(episode)
}

/// The shapes of a spec's tools.
pub(super) fn tools(spec: &DatasetSpec) -> anyhow::Result<IndexMap<String, Arc<ToolShape>>> {
    let shape = |(name, tool): (&String, &ToolSpec)| {
        let tool = tool.clone().build().with_context(|| format!("the tool `{name}` cannot be built"))?;
        Ok((name.clone(), tool.shape().clone()))
    };
    spec.tool.iter().map(shape).collect()
}
