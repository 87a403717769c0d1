//! One model and one folder of episodes, without a comparison around them.
use super::{Artifacts, Contender, ContenderSpec};
use crate::config::fingerprint;
use crate::data::{Dataset, HELD_OUT};
use crate::train::Split;
use crate::watch::Watch;
use std::path::Path;

/// Fits the model `name` to the dataset in `folder`, below `root`, and says how well it predicts what that holds out; what an earlier
/// run has fitted is reused.
///
/// # Errors
/// When the folder holds no whole dataset, and as [`ContenderSpec::fit`].
pub fn train(name: &str, spec: &ContenderSpec, folder: &Path, root: &Path, watch: &Watch) -> anyhow::Result<Contender> {
    let dataset = Dataset::load(folder)?;
    let mark = fingerprint(&dataset.metadata);
    spec.fit(name, &Split::of(&dataset, HELD_OUT), &mark, &Artifacts::below(root), watch)
}
