//! Whether a folder of episodes is whole: hashes, files, and what it says of itself.
use super::contents::Contents;
use super::sums::{SUMS, read_sums, sha256};
use super::{Episode, Metadata};
use anyhow::{Context, ensure};
use indexmap::IndexSet;
use rayon::prelude::*;
use serde_json::Value as Json;
use std::path::Path;

/// What [`check`] found.
#[derive(Clone, Debug)]
pub struct Check {
    /// Number of episodes.
    pub episodes: usize,
    /// Number of files that have a hash; `None` in a folder from before there were hashes.
    pub hashed: Option<usize>,
    /// A sentence for each bad file, with its name and the fix.
    pub faults: Vec<String>,
}

/// Compares every file of the dataset in `folder` with its hash, reads every episode, and compares the metadata with both the
/// spec and the episodes.
///
/// # Errors
/// When the folder holds no dataset or an unfinished one, or its hashes cannot be read.
pub fn check(folder: &Path) -> anyhow::Result<Check> {
    let contents = Contents::read(folder)?;
    let sums = read_sums(folder)?;
    let fix = if contents.spec.is_some() { "simulate" } else { "import" };
    let mut bad: IndexSet<String> = IndexSet::new();
    let mut faults: Vec<String> = Vec::new();
    if let Some(sums) = &sums {
        let differs = |(name, hash): (&String, &String)| {
            let path = folder.join(name);
            let fault = match sha256(&path) {
                Ok(found) if found == *hash => return None,
                Ok(_) => {
                    format!("{} is not the file whose hash {SUMS} holds; remove it and {fix} again", path.display())
                }
                Err(_) if !path.exists() => format!("{} is missing; {fix} again", path.display()),
                Err(error) => format!("{error:#}"),
            };
            Some((name.clone(), fault))
        };
        let found: Vec<(String, String)> =
            sums.iter().collect::<Vec<_>>().into_par_iter().filter_map(differs).collect();
        for (name, fault) in found {
            faults.push(fault);
            bad.insert(name);
        }
        let unlisted = contents.metadata.files().into_iter().filter(|name| !sums.contains_key(name));
        faults.extend(unlisted.map(|name| format!("{name} has no hash in {SUMS}; {fix} again")));
    }
    let mut episodes: Vec<Episode> = Vec::new();
    for (entry, read) in contents.metadata.episodes.iter().zip(contents.attempt(folder)) {
        match read {
            Ok(episode) => episodes.push(episode),
            Err(_) if bad.contains(&entry.file) => {}
            Err(error) => faults.push(format!("{error:#}")),
        }
    }
    if episodes.len() == contents.metadata.episodes.len() {
        let path = folder.join(Metadata::FILE);
        let sentence = |key| {
            format!("`{key}` in {} is not that of the spec and the episodes; remove it and {fix} again", path.display())
        };
        faults.extend(disagreements(&contents, &episodes)?.into_iter().map(sentence));
    }
    faults.extend(strangers(folder, &contents.metadata)?);
    Ok(Check { episodes: contents.metadata.episodes.len(), hashed: sums.map(|s| s.len()), faults })
}

impl Check {
    /// One sentence of a whole folder.
    ///
    /// # Errors
    /// All faults, a line each.
    pub fn verdict(&self) -> anyhow::Result<String> {
        let (count, lines) = (self.faults.len(), self.faults.join("\n  "));
        ensure!(count == 0, "{count} fault{}:\n  {lines}", if count == 1 { "" } else { "s" });
        let hashes = match self.hashed {
            Some(files) => format!("{files} files have the hashes of {SUMS}"),
            None => {
                format!("there is no {SUMS}: the folder is from before hashes were written; simulating again adds them")
            }
        };
        Ok(format!("{} episodes read, the metadata agrees, and {hashes}", self.episodes))
    }
}

/// Keys of the metadata whose values are not those of the spec and the episodes.
fn disagreements(contents: &Contents, episodes: &[Episode]) -> anyhow::Result<Vec<String>> {
    let expected = contents.metadata.again(contents.spec.as_ref(), episodes)?;
    let json = |metadata: &Metadata| serde_json::to_value(metadata).context("the metadata cannot be written as JSON");
    let (Json::Object(found), Json::Object(expected)) = (json(&contents.metadata)?, json(&expected)?) else {
        return Ok(Vec::new());
    };
    Ok(expected
        .iter()
        .filter(|(key, value)| !found.get(*key).is_some_and(|v| agree(v, value)))
        .map(|(k, _)| k.clone())
        .collect())
}

/// Whether two values are equal, numbers up to rounding: the order of a sum may differ between versions.
fn agree(a: &Json, b: &Json) -> bool {
    match (a, b) {
        (Json::Number(a), Json::Number(b)) => {
            let (a, b) = (a.as_f64().unwrap_or(f64::NAN), b.as_f64().unwrap_or(f64::NAN));
            (a - b).abs() <= 1e-9 * a.abs().max(b.abs()).max(1e-3)
        }
        (Json::Array(a), Json::Array(b)) => a.len() == b.len() && a.iter().zip(b).all(|(a, b)| agree(a, b)),
        (Json::Object(a), Json::Object(b)) => {
            a.len() == b.len() && a.iter().all(|(key, value)| b.get(key).is_some_and(|other| agree(value, other)))
        }
        (a, b) => a == b,
    }
}

/// A sentence for each episode file that the metadata does not list.
fn strangers(folder: &Path, metadata: &Metadata) -> anyhow::Result<Vec<String>> {
    let entries = std::fs::read_dir(folder).with_context(|| format!("cannot list {}", folder.display()))?;
    let names = entries.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned());
    let strange = |name: &String| name.ends_with(".npz") && !metadata.episodes.iter().any(|e| e.file == *name);
    let mut names: Vec<String> = names.filter(strange).collect();
    names.sort();
    let sentence = |name: String| format!("{} is no episode of this dataset; remove it", folder.join(name).display());
    Ok(names.into_iter().map(sentence).collect())
}
