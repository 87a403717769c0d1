//! A model of the comparison: its dynamics, and the stages that fit it to data, each an artifact of its own.
use super::Artifacts;
use crate::config::{Fingerprint, hold, write_whole};
use crate::model::{ModelSpec, WorldModel};
use crate::train::policy::Policy;
use crate::train::{Evaluation, FitSpec, Split, evaluate};
use crate::watch::Watch;
use anyhow::Context;
use indexmap::IndexMap;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Config of one contender: `configs/model/*.toml`, whose file stem is its name in tables.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ContenderSpec {
    /// Stages of `configs/train/*.toml` that fit the model, in order; none when there is nothing to fit.
    #[serde(default)]
    pub train: IndexMap<String, FitSpec>,
    /// Stages of `configs/adapt/*.toml` that follow in the scene that is planned in, where there are interactions to learn from.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub adapt: IndexMap<String, FitSpec>,
    /// The model, before it is fitted.
    pub dynamics: ModelSpec,
}

/// A contender ready to plan.
pub struct Contender {
    /// Its name in tables.
    pub name: String,
    /// The fitted model.
    pub model: Box<dyn WorldModel>,
    /// Its errors on episodes that no fit has seen; none where it cannot start from a recorded frame (the simulator).
    pub held_out: Option<Evaluation>,
    /// Folder of each stage that fitted it, by stage name.
    pub stages: IndexMap<String, PathBuf>,
    /// What has learned from its rollouts to propose actions, by tool; none unless a planner asks for it.
    pub policies: IndexMap<String, Policy>,
}

impl ContenderSpec {
    /// Fits the model stage by stage, reusing what an earlier run with the same data, dynamics and stages has made.
    ///
    /// # Errors
    /// An impossible spec, a fit that fails, or a stop that was asked for.
    pub fn fit(
        &self,
        name: &str,
        data: &Split,
        dataset: &Fingerprint,
        artifacts: &Artifacts,
        watch: &Watch,
    ) -> anyhow::Result<Contender> {
        self.adapted(name, (data, dataset), None, artifacts, watch)
    }

    /// The same, and then its `adapt` stages on the `interactions`, where there are both; judged on what the last data hold out.
    pub(super) fn adapted(
        &self,
        name: &str,
        lesson: (&Split, &Fingerprint),
        interactions: Option<(&Split, &Fingerprint)>,
        artifacts: &Artifacts,
        watch: &Watch,
    ) -> anyhow::Result<Contender> {
        let mut stages = IndexMap::new();
        let mut dynamics = staged(name, (&self.dynamics, &self.train), lesson, &mut stages, artifacts, watch)?;
        let (data, _) = interactions.unwrap_or(lesson);
        if let Some(interactions) = interactions {
            dynamics = staged(name, (&dynamics, &self.adapt), interactions, &mut stages, artifacts, watch)?;
        }
        let model = dynamics.build().with_context(|| format!("building the model {name}"))?;
        let held_out = match starts_from_recordings(model.as_ref(), data) {
            true => Some(
                evaluate(model.as_ref(), &data.held_out, &data.tools).with_context(|| format!("evaluating {name}"))?,
            ),
            false => None,
        };
        Ok(Contender { name: name.to_owned(), model, held_out, stages, policies: IndexMap::new() })
    }
}

/// What a model has become after these stages; the folder of each is added to `folders`.
fn staged(
    name: &str,
    (start, stages): (&ModelSpec, &IndexMap<String, FitSpec>),
    (data, dataset): (&Split, &Fingerprint),
    folders: &mut IndexMap<String, PathBuf>,
    artifacts: &Artifacts,
    watch: &Watch,
) -> anyhow::Result<ModelSpec> {
    let mut dynamics = start.clone();
    for (k, (stage, fit)) in stages.iter().enumerate() {
        let history: Vec<&FitSpec> = stages.values().take(k + 1).collect();
        let recipe = Recipe { dataset: dataset.to_string(), dynamics: start, stages: history };
        let (folder, _) = artifacts.folder("fit", &recipe);
        let _held = hold(&folder)?;
        dynamics = match read_fitted(&folder)? {
            Some(fitted) => fitted,
            None => {
                write_whole(&folder.join("recipe.json"), &serde_json::to_vec_pretty(&recipe)?)?;
                let fitted = fit.clone().build()?.fit(&dynamics, data, &folder, watch);
                let fitted = fitted.with_context(|| format!("fitting {name}, stage {stage}"))?;
                let text = serde_json::to_string_pretty(&fitted).expect("specs are plain data");
                write_whole(&folder.join(FITTED), text.as_bytes())?;
                fitted
            }
        };
        folders.insert(stage.clone(), folder);
    }
    Ok(dynamics)
}

/// All that a fit depends on: its folder is named by the fingerprint of this, which stands in it as `recipe.json`.
#[derive(Serialize)]
struct Recipe<'a> {
    /// Fingerprint of the episodes.
    dataset: String,
    /// The model before the first stage.
    dynamics: &'a ModelSpec,
    /// The stages up to this one.
    stages: Vec<&'a FitSpec>,
}

/// Whether the model can start from a recorded frame, which the simulator, needing its whole state, cannot.
fn starts_from_recordings(model: &dyn WorldModel, data: &Split) -> bool {
    let first = data.held_out.first();
    first.is_some_and(|episode| model.accepts(&episode.scene(0, &data.tools[&episode.tool])).is_ok())
}

const FITTED: &str = "fitted.json";

/// The model that a stage left in its folder, if it has finished.
pub(super) fn read_fitted(folder: &Path) -> anyhow::Result<Option<ModelSpec>> {
    let path = folder.join(FITTED);
    if !path.exists() {
        return Ok(None);
    }
    let text = std::fs::read_to_string(&path).with_context(|| format!("cannot read {}", path.display()))?;
    let spec = serde_json::from_str(&text);
    let fitted =
        spec.with_context(|| format!("{} is not a fitted model; delete its folder to fit again", path.display()))?;
    Ok(Some(fitted))
}
