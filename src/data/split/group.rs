//! Held out by name: a tool, a material or a start that no fit sees.
use super::{DatasetSpec, Entry, Episode, HoldOut};
use anyhow::ensure;
use indexmap::IndexSet;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// All episodes with some tools, materials or starts are held out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GroupSpec {
    /// What the names are names of.
    pub by: By,
    /// Names of what is held out; by default the last one of the dataset's list.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub held_out: Vec<String>,
}

/// What episodes can be told apart by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum By {
    /// The tool of the recorded action.
    Tool,
    /// The material, where the dataset lists several.
    Material,
    /// The start, where the dataset lists several.
    Start,
}

impl GroupSpec {
    /// Nothing to check before the dataset is known.
    ///
    /// # Errors
    /// Never.
    pub fn build(self) -> anyhow::Result<impl HoldOut> {
        Ok(self)
    }
}

impl By {
    fn name(self, entry: &Entry) -> Option<&str> {
        match self {
            Self::Tool => Some(&entry.tool),
            Self::Material => entry.material.as_deref(),
            Self::Start => entry.start.as_deref(),
        }
    }

    /// The dataset's list of names, and its key.
    fn list(self, spec: &DatasetSpec) -> (&'static str, Vec<&str>) {
        match self {
            Self::Tool => ("tool", spec.tool.keys().map(String::as_str).collect()),
            Self::Material => ("material", spec.material.keys().map(String::as_str).collect()),
            Self::Start => ("start", spec.start.keys().map(String::as_str).collect()),
        }
    }
}

impl HoldOut for GroupSpec {
    fn held_out(&self, _: &[Episode], entries: &[Entry], _: f64) -> Vec<bool> {
        let names: IndexSet<&str> = entries.iter().filter_map(|e| self.by.name(e)).collect();
        let out = |name: &str| match &self.held_out[..] {
            [] => names.len() > 1 && names.last() == Some(&name),
            chosen => chosen.iter().any(|c| c == name),
        };
        entries.iter().map(|entry| self.by.name(entry).is_some_and(out)).collect()
    }

    fn check(&self, spec: &DatasetSpec) -> anyhow::Result<()> {
        let (key, names) = self.by.list(spec);
        let shown = names.join(", ");
        ensure!(
            names.len() > 1,
            "`split.by` is \"{key}\", but `{key}` lists {}; list at least two, such as `{key}=[…, …]`",
            if names.is_empty() { "nothing" } else { &shown }
        );
        for name in &self.held_out {
            ensure!(
                names.contains(&&name[..]),
                "`split.held_out` names \"{name}\", which `{key}` does not list; there is {shown}"
            );
        }
        let left = names.iter().filter(|name| !self.held_out.iter().any(|out| out == *name)).count();
        ensure!(left > 0, "`split.held_out` names every {key}; leave one to learn from");
        let occurring: IndexSet<&str> = (0..spec.episodes)
            .take(spec.combinations())
            .filter_map(|k| match self.by {
                By::Tool => Some(spec.tool_of(k)),
                By::Material => spec.material_of(k).map(|(name, _)| name),
                By::Start => spec.start_of(k).map(|(name, _)| name),
            })
            .collect();
        ensure!(
            occurring.len() == names.len(),
            "`episodes` is {}, so that not every {key} occurs; make at least {} of them",
            spec.episodes,
            spec.combinations()
        );
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::metadata::Entry;
    use super::*;

    #[test]
    fn the_named_or_else_the_last_are_held_out() {
        let entry = |tool: &str, material: Option<&str>| Entry {
            constants: indexmap::IndexMap::new(),
            file: String::new(),
            tool: tool.into(),
            theta: Vec::new(),
            material: material.map(str::to_owned),
            start: None,
            part: None,
        };
        let entries = [entry("grip", Some("dough")), entry("press", Some("dough")), entry("grip", Some("clay"))];
        let held = |by, names: &[&str]| {
            let held_out = names.iter().map(|n| (*n).to_owned()).collect();
            GroupSpec { by, held_out }.held_out(&[], &entries, 0.2)
        };
        assert_eq!(held(By::Tool, &["grip"]), [true, false, true]);
        assert_eq!(held(By::Tool, &[]), [false, true, false]);
        assert_eq!(held(By::Material, &[]), [false, false, true]);
        assert_eq!(held(By::Start, &[]), [false; 3]);
    }
}
