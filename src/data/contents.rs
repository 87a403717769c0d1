//! What a finished folder says of itself, and the way to each of its episodes.
use super::dataset::{DatasetSpec, SPEC, read_episode, read_spec, tools};
use super::{Episode, Metadata};
use crate::state::ToolShape;
use anyhow::{Context, ensure};
use indexmap::IndexMap;
use rayon::prelude::*;
use std::path::Path;
use std::sync::Arc;

/// The spec of a simulated folder, and the metadata of any.
pub(super) struct Contents {
    /// What was simulated; `None` of recordings.
    pub(super) spec: Option<DatasetSpec>,
    /// Its `metadata.json`.
    pub(super) metadata: Metadata,
}

impl Contents {
    /// Reads what `folder` says of itself.
    ///
    /// # Errors
    /// When it holds no dataset, or an unfinished one, or its spec and its metadata are not of the same dataset.
    pub(super) fn read(folder: &Path) -> anyhow::Result<Self> {
        let spec = read_spec(folder)?;
        ensure!(
            spec.is_some() || folder.join(Metadata::FILE).exists(),
            "{} holds no dataset (no {SPEC}); simulate one there first",
            folder.display()
        );
        let metadata = Metadata::read(folder)?;
        let (listed, wanted) = (metadata.episodes.len(), spec.as_ref().map(|s| s.episodes));
        ensure!(
            wanted.is_some() || metadata.is_imported(),
            "{} is missing, and without it a simulated dataset cannot be read; simulate again",
            folder.join(SPEC).display()
        );
        ensure!(
            wanted.is_none_or(|n| n == listed) && listed > 0,
            "{} lists {listed} episodes, not {}; simulate again",
            folder.join(Metadata::FILE).display(),
            wanted.unwrap_or(1)
        );
        Ok(Self { spec, metadata })
    }

    /// Episode `k` of `folder`.
    ///
    /// # Errors
    /// As [`Episode::read`]; also when its length is not the spec's.
    pub(super) fn episode(&self, folder: &Path, k: usize) -> anyhow::Result<Episode> {
        let entry = &self.metadata.episodes[k];
        let path = folder.join(&entry.file);
        let episode = match &self.spec {
            Some(spec) => read_episode(&path, &entry.tool, spec.steps),
            None => Episode::read(&path, &entry.tool),
        };
        Ok(Episode { constants: entry.constants.clone().into(), ..episode? })
    }

    /// All episodes of `folder`, in order and in parallel, each or the sentence of why not.
    pub(super) fn attempt(&self, folder: &Path) -> Vec<anyhow::Result<Episode>> {
        (0..self.metadata.episodes.len()).into_par_iter().map(|k| self.episode(folder, k)).collect()
    }

    /// The shapes of the tools: those of the spec, or of recordings that without parts.
    pub(super) fn tools(&self, folder: &Path) -> anyhow::Result<IndexMap<String, Arc<ToolShape>>> {
        match &self.spec {
            Some(spec) => tools(spec).with_context(|| format!("in {}", folder.join(SPEC).display())),
            None => {
                let none = Arc::new(ToolShape::from(Vec::new()));
                Ok(self.metadata.episodes.iter().map(|e| (e.tool.clone(), none.clone())).collect())
            }
        }
    }
}
