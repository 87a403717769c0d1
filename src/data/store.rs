//! Episodes that came about one by one, as a folder like any other.
use super::dataset::{SPEC, episode_path};
use super::sums::write_sums;
use super::{DatasetSpec, Episode, Metadata};
use crate::config::write_whole;
use anyhow::Context;
use std::path::Path;

/// Writes `episodes`, of which number k was made with tool number k of `spec`, as the dataset in `folder`.
///
/// # Errors
/// When there is no episode, or a file cannot be written.
pub fn store(spec: &DatasetSpec, episodes: &[Episode], folder: &Path) -> anyhow::Result<()> {
    anyhow::ensure!(!episodes.is_empty(), "no episode is there to be written to {}", folder.display());
    let text = toml_edit::ser::to_string_pretty(spec).context("the dataset's spec cannot be written as TOML")?;
    write_whole(&folder.join(SPEC), text.as_bytes())?;
    for (k, episode) in episodes.iter().enumerate() {
        episode.write(&episode_path(folder, k))?;
    }
    let metadata = Metadata::describe(spec, episodes)?;
    metadata.write(folder)?;
    write_sums(folder, &metadata.files())
}
