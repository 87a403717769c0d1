//! Recordings of others as a dataset.
mod boxbath;

use super::metadata::Entry;
use super::split::{GivenSpec, Part, SplitSpec};
use super::sums::write_sums;
use super::{Dataset, Episode, Metadata};
use crate::config::hold;
use crate::state::ToolShape;
use anyhow::{Context, ensure};
use boxbath::Boxbath;
use indexmap::IndexMap;
use rayon::prelude::*;
use serde_json::json;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What recordings call their tool: they have none.
pub(super) const NO_TOOL: &str = "none";

/// A format that others record in.
pub trait Recording: Sync {
    /// Its name on the command line and in metadata.
    fn name(&self) -> &'static str;

    /// What each body is, by its number.
    fn bodies(&self) -> &'static [&'static str];

    /// The recording in the file at `path`, in metres, z up, the table at z = 0.
    ///
    /// # Errors
    /// When the file is not of this format: a sentence with the file and the fix.
    fn read(&self, path: &Path) -> anyhow::Result<Episode>;

    /// What the file's name says it is for.
    fn part(&self, stem: &str) -> Part;
}

/// The formats that can be imported.
pub const RECORDINGS: &[&dyn Recording] = &[&Boxbath];

/// Fills `folder` with the recordings at `source`, a `.npz` file or a folder of them, in the order of their names.
///
/// The folder is then a dataset like any other, with one tool of no parts, and held out is what the recordings say.
///
/// # Errors
/// When there is nothing to read, a file is not of the format (then nothing is written), `folder` is not empty, or cannot be
/// written to.
pub fn import(source: &Path, format: &dyn Recording, folder: &Path) -> anyhow::Result<Dataset> {
    let files = files(source)?;
    let episodes: Vec<Episode> = files.par_iter().map(|file| format.read(file)).collect::<anyhow::Result<_>>()?;
    let _held = hold(folder)?;
    let occupied = std::fs::read_dir(folder)
        .with_context(|| format!("cannot list {}", folder.display()))?
        .flatten()
        .any(|entry| entry.file_name() != "lock");
    ensure!(!occupied, "{} is not empty; import into a new folder", folder.display());

    let name = |path: &PathBuf| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let entry = |(k, path): (usize, &PathBuf)| {
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        Entry { part: Some(format.part(&stem)), ..Entry::of(k, &episodes[k]) }
    };
    let entries: Vec<Entry> = files.iter().enumerate().map(entry).collect();
    let origin = json!({
        "format": format.name(),
        "bodies": format.bodies(),
        "files": files.iter().map(name).collect::<Vec<_>>(),
    });
    let split = SplitSpec::Given(GivenSpec {});
    let metadata = Metadata::recorded(format.name(), origin, split, entries, &episodes)?;
    for (entry, episode) in metadata.episodes.iter().zip(&episodes) {
        episode.write(&folder.join(&entry.file))?;
    }
    metadata.write(folder)?;
    write_sums(folder, &metadata.files())?;
    let tools = IndexMap::from([(NO_TOOL.to_owned(), Arc::new(ToolShape::from(Vec::new())))]);
    Ok(Dataset { episodes, tools, metadata })
}

/// The `.npz` files at `source`, by name.
fn files(source: &Path) -> anyhow::Result<Vec<PathBuf>> {
    if !source.is_dir() {
        return Ok(vec![source.to_owned()]);
    }
    let entries = std::fs::read_dir(source).with_context(|| format!("cannot list {}", source.display()))?;
    let paths = entries.flatten().map(|entry| entry.path());
    let mut files: Vec<PathBuf> = paths.filter(|path| path.extension().is_some_and(|e| e == "npz")).collect();
    files.sort();
    ensure!(!files.is_empty(), "{} holds no .npz file; name a folder of recordings or one file", source.display());
    Ok(files)
}
