//! The policies that planners ask for, one a contender and tool, each an artifact of its own.
use super::{Artifacts, CompareSpec, Contender, ContenderSpec};
use crate::config::{Fingerprint, write_whole};
use crate::tool::{Tool, ToolSpec};
use crate::train::Split;
use crate::train::policy::{Policy, PolicySpec};
use crate::watch::Watch;
use anyhow::Context;
use indexmap::IndexMap;
use serde::Serialize;
use std::borrow::Cow;

/// All that a policy depends on: its folder is named by the fingerprint of this, which stands in it as `recipe.json`.
#[derive(Serialize)]
struct Recipe<'a> {
    /// Fingerprint of the episodes whose first states it begins from, and that its model is fitted to.
    dataset: String,
    /// The model that it learns from.
    model: &'a ContenderSpec,
    /// Names of the folders of the stages that fitted it, which are fingerprints of all that each depends on, interactions too.
    fits: Vec<Cow<'a, str>>,
    tool: &'a ToolSpec,
    steps: usize,
    policy: &'a PolicySpec,
}

/// The policy of each tool under `contender`, where its model is one that a policy can be learned from.
pub(super) fn policies(
    contender: &Contender,
    spec: &CompareSpec,
    tools: &IndexMap<String, Box<dyn Tool>>,
    (data, dataset): (&Split, &Fingerprint),
    watch: &Watch,
) -> anyhow::Result<IndexMap<String, Policy>> {
    let artifacts = Artifacts::below(&spec.artifacts);
    let mut policies = IndexMap::new();
    for (name, tool) in tools {
        let recipe = Recipe {
            dataset: dataset.to_string(),
            model: &spec.model[&contender.name],
            fits: contender.stages.values().filter_map(|folder| Some(folder.file_name()?.to_string_lossy())).collect(),
            tool: &spec.dataset.tool[name],
            steps: spec.dataset.steps,
            policy: &spec.policy,
        };
        let (folder, _) = artifacts.folder("policy", &recipe);
        let (model, steps) = (contender.model.as_ref(), spec.dataset.steps);
        let fitted = spec.policy.fit(model, tool.as_ref(), &data.train, steps, &folder, watch);
        let fitted = fitted.with_context(|| format!("learning a policy of {name} from {}", contender.name))?;
        let Some(policy) = fitted else { continue };
        let told = folder.join("recipe.json");
        if !told.exists() {
            write_whole(&told, &serde_json::to_vec_pretty(&recipe)?)?;
        }
        policies.insert(name.clone(), policy);
    }
    Ok(policies)
}
