//! Files that are either there whole or not there.
use anyhow::{Result, anyhow};
use std::fs::{self, File, OpenOptions};
use std::io::{ErrorKind, Write};
use std::path::Path;

/// Whether two paths lead to the same existing file or folder.
pub fn same_place(a: &Path, b: &Path) -> bool {
    a.canonicalize().is_ok_and(|a| b.canonicalize().is_ok_and(|b| a == b))
}

/// Writes a file so that readers, and runs after a crash, see all of it or what was there before.
///
/// The bytes go to a temporary file in the same folder, are synced, and take the name by renaming. Folders on the way are
/// made.
///
/// # Errors
/// A sentence naming the file: the disk is full, the folder cannot be made, something of that name is a folder.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    let name = path.file_name().ok_or_else(|| anyhow!("cannot write `{}`: it names no file", path.display()))?;
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    fs::create_dir_all(folder).map_err(|error| sentence("make the folder", folder, &error))?;
    if path.is_dir() {
        return Err(anyhow!("cannot write `{}`: a folder of that name is in the way", path.display()));
    }
    // process and thread make the name unique among the living; what a killed one left is overwritten by its successor
    let unique = format!(".{}.{}.{:?}.tmp", name.to_string_lossy(), std::process::id(), std::thread::current().id());
    let temporary = folder.join(unique);
    let written = fill(&temporary, bytes).and_then(|()| fs::rename(&temporary, path));
    if let Err(error) = written {
        // the first error is the one to report; a temporary file that cannot be removed is only clutter
        let _ = fs::remove_file(&temporary);
        return Err(sentence("write", path, &error));
    }
    // the rename itself survives a power cut only when the folder is synced; not every file system can
    let _ = File::open(folder).and_then(|folder| folder.sync_all());
    Ok(())
}

fn fill(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    let mut options = OpenOptions::new();
    options.write(true).create(true).truncate(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o644);
    let mut file = options.open(path)?;
    file.write_all(bytes)?;
    file.sync_all()
}

fn sentence(verb: &str, path: &Path, error: &std::io::Error) -> anyhow::Error {
    let why = match error.kind() {
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => "the disk is full: make room and run it again".to_owned(),
        ErrorKind::PermissionDenied => "this user may not write there".to_owned(),
        ErrorKind::NotADirectory | ErrorKind::AlreadyExists => "a file is where a folder should be".to_owned(),
        ErrorKind::ReadOnlyFilesystem => "the file system is read-only".to_owned(),
        _ => error.to_string(),
    };
    anyhow!("cannot {verb} `{}`: {why}", path.display())
}
