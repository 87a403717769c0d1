//! Files that are there whole or not at all.
use anyhow::Context;
use std::path::Path;

/// Writes a file beside its place and renames it, so that a reader finds all of the old one or all of the new one.
///
/// # Errors
/// A sentence naming the file when the folder is missing, read-only or full.
pub(super) fn write_whole(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    let draft = path.with_extension(PART);
    std::fs::write(&draft, bytes)
        .and_then(|()| std::fs::rename(&draft, path))
        .with_context(|| format!("cannot write {}; is the disk full or the folder read-only?", path.display()))
}

/// Extension of a file that is not whole yet.
pub(super) const PART: &str = "part";
