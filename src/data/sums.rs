//! Hashes of a folder's files, in the format of `sha256sum`.
use crate::config::write_whole;
use anyhow::{Context, bail};
use indexmap::IndexMap;
use rayon::prelude::*;
use sha2::{Digest, Sha256};
use std::fs::File;
use std::io::ErrorKind;
use std::path::Path;

/// The file of hashes; `sha256sum -c SHA256SUMS` checks a folder without Pliant.
pub(super) const SUMS: &str = "SHA256SUMS";

/// Writes the hashes of `files`, names in `folder`, whole.
///
/// # Errors
/// When one of them cannot be read, or the hashes cannot be written.
pub(super) fn write_sums(folder: &Path, files: &[String]) -> anyhow::Result<()> {
    let line = |name: &String| Ok(format!("{}  {name}\n", sha256(&folder.join(name))?));
    let lines: Vec<String> = files.par_iter().map(line).collect::<anyhow::Result<_>>()?;
    write_whole(&folder.join(SUMS), lines.concat().as_bytes())
}

/// Hash by file name, or `None` where a folder has no hashes.
///
/// # Errors
/// When they cannot be read, or a line is not a hash and a name.
pub(super) fn read_sums(folder: &Path) -> anyhow::Result<Option<IndexMap<String, String>>> {
    let path = folder.join(SUMS);
    let text = match std::fs::read_to_string(&path) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        read => read.with_context(|| format!("cannot read {}", path.display()))?,
    };
    let parse = |(i, line): (usize, &str)| {
        // The second character between hash and name is `*` where sha256sum was asked for binary mode.
        match line.split_at_checked(64).map(|(hash, rest)| (hash, rest.strip_prefix(' '))) {
            Some((hash, Some(rest))) if rest.starts_with([' ', '*']) => Ok((rest[1..].to_owned(), hash.to_lowercase())),
            _ => bail!("line {} of {} is not a hash and a name; make the hashes again", i + 1, path.display()),
        }
    };
    text.lines().enumerate().map(parse).collect::<anyhow::Result<_>>().map(Some)
}

/// SHA-256 of a file, in hexadecimal digits.
///
/// # Errors
/// When it cannot be read.
pub(super) fn sha256(path: &Path) -> anyhow::Result<String> {
    let hash = || -> std::io::Result<_> {
        let mut hasher = Sha256::new();
        std::io::copy(&mut File::open(path)?, &mut hasher)?;
        Ok(hasher.finalize())
    };
    let hash = hash().with_context(|| format!("cannot read {}", path.display()))?;
    Ok(hash.iter().map(|byte| format!("{byte:02x}")).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hashes_come_back_and_are_those_of_the_standard() {
        let folder = tempfile::tempdir().unwrap();
        let names = ["abc", "empty"].map(str::to_owned);
        std::fs::write(folder.path().join("abc"), "abc").unwrap();
        std::fs::write(folder.path().join("empty"), "").unwrap();
        assert!(read_sums(folder.path()).unwrap().is_none());
        write_sums(folder.path(), &names).unwrap();
        // FIPS 180-4's example, and the hash of nothing.
        let text = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad  abc\n\
                    e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855  empty\n";
        assert_eq!(std::fs::read_to_string(folder.path().join(SUMS)).unwrap(), text);
        let read = read_sums(folder.path()).unwrap().unwrap();
        assert_eq!(read.keys().collect::<Vec<_>>(), ["abc", "empty"]);
        assert_eq!(read["abc"], text[..64]);
        std::fs::write(folder.path().join(SUMS), text.replace("  ", " *")).unwrap();
        assert_eq!(read_sums(folder.path()).unwrap().unwrap(), read);
        for odd in ["abc", &text[..64], &text[..65], "é", &text.replace("  ", " ")] {
            std::fs::write(folder.path().join(SUMS), odd).unwrap();
            assert!(format!("{:#}", read_sums(folder.path()).unwrap_err()).contains("line 1 of"), "{odd}");
        }
    }
}
