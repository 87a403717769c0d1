//! Where artifacts live: one folder each, named by the fingerprint of the resolved config that made it.
use crate::config::{Fingerprint, fingerprint};
use crate::data::DatasetSpec;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// The root of everything a comparison makes.
#[derive(Clone, Debug)]
pub struct Artifacts {
    root: PathBuf,
}

impl Artifacts {
    /// Artifacts below `root`; nothing is created yet.
    pub fn below(root: &Path) -> Self {
        Self { root: root.to_owned() }
    }

    /// The folder of the artifact of this kind made by `spec`, and its fingerprint.
    pub fn folder(&self, kind: &str, spec: &impl Serialize) -> (PathBuf, Fingerprint) {
        let mark = fingerprint(spec);
        (self.root.join(kind).join(mark.to_string()), mark)
    }
}

/// The folder of the dataset that `spec` describes, below `root`.
pub fn dataset_folder(root: &Path, spec: &DatasetSpec) -> PathBuf {
    Artifacts::below(root).folder("dataset", spec).0
}
