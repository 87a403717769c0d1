//! One model and one folder of episodes, without a comparison around them.
use super::{Artifacts, Contender, ContenderSpec};
use crate::config::{self, fingerprint};
use crate::data::{Dataset, HELD_OUT};
use crate::train::Split;
use crate::watch::Watch;
use anyhow::ensure;
use std::path::Path;

/// Fits the model that the file `model` and `overrides` of its keys describe to the dataset in `folder`, below `root`, and says how
/// well it predicts what that holds out; what an earlier run has fitted is reused. The file's stem is the model's name.
///
/// # Errors
/// When there is no such file or its config is impossible, the folder holds no whole dataset, and as [`ContenderSpec::fit`].
pub fn train(
    model: &Path,
    overrides: &[String],
    folder: &Path,
    root: &Path,
    watch: &Watch,
) -> anyhow::Result<Contender> {
    ensure!(
        model.is_file(),
        "{} is no file; name a model's TOML such as configs/model/learned.toml, or, to draw a model of a comparison, that by --compare",
        model.display()
    );
    fit_to(&config::load::<ContenderSpec>(model, overrides)?.spec, model, folder, root, watch)
}

/// Fits `spec`, which came from the file `model` and is called by its stem, to the dataset in `folder`.
pub(super) fn fit_to(
    spec: &ContenderSpec,
    model: &Path,
    folder: &Path,
    root: &Path,
    watch: &Watch,
) -> anyhow::Result<Contender> {
    let name = model.file_stem().unwrap_or_default().to_string_lossy();
    let dataset = Dataset::load(folder)?;
    let mark = fingerprint(&dataset.metadata);
    spec.fit(&name, &Split::of(&dataset, HELD_OUT), &mark, &Artifacts::below(root), watch)
}
