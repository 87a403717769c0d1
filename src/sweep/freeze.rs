//! Every trial's config is written down before the first trial runs.
use super::trial::{FrozenTrial, Record};
use super::{SweepSpec, plan};
use crate::config::{Spec, fingerprint, load, meaning, write_whole};
use anyhow::{Context, Result, bail, ensure};
use indexmap::IndexMap;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// A sweep whose trials can no longer change.
#[derive(Clone, Debug)]
pub struct Frozen {
    /// Its folder.
    pub folder: PathBuf,
    /// The words of the command.
    pub command: Vec<String>,
    /// Its trials, each config once, in the order of the plan.
    pub trials: Vec<FrozenTrial>,
    /// The name of the file that marks a trial as done.
    pub result: String,
}

/// What `sweep.json` in the folder of a sweep says.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Index {
    pub(super) command: Vec<String>,
    pub(super) result: String,
    pub(super) trials: IndexMap<String, Record>,
}

impl Index {
    pub(super) fn path(folder: &Path) -> PathBuf {
        folder.join("sweep.json")
    }
}

/// Resolves every trial against `T` and writes each as `<out>/<sweep>/<trial>/config.toml`; files already there stay.
///
/// # Errors
/// A trial's config is wrong or there are no trials, and nothing is written; or a file cannot be written.
pub fn freeze<T: Spec>(spec: &SweepSpec) -> Result<Frozen> {
    if let Some((key, _)) = spec.grid.iter().find(|(_, values)| values.is_empty()) {
        bail!("the sweep has no trials: give `grid.{key}` at least one value");
    }
    let mut configs = Vec::new();
    let mut records = IndexMap::new();
    for trial in plan(spec) {
        let loaded = load::<T>(&spec.base, &trial.overrides)
            .with_context(|| format!("the config of trial `{}` is wrong", trial.overrides.join(" ")))?;
        let name = fingerprint(&loaded.spec).to_string();
        let overrides = trial.overrides.iter().map(|text| meaning(text)).collect::<Result<_, _>>()?;
        // two ways to write the same config are one trial
        if !records.contains_key(&name) {
            records.insert(name, Record { change: trial.label, overrides });
            configs.push(loaded.resolved.to_toml());
        }
    }
    let command = match &spec.command[..] {
        [] => {
            let own = std::env::current_exe().context("cannot find this program's own file; set `command`")?;
            let program = own.with_file_name(format!("pliant{}", std::env::consts::EXE_SUFFIX));
            ensure!(program.exists(), "{} is not built; run `cargo build --release`", program.display());
            vec![program.display().to_string(), "compare".to_owned()]
        }
        words => words.to_vec(),
    };
    let names: Vec<&String> = records.keys().collect();
    // the configured words, not the path of this program: a rebuilt or moved program continues its sweeps
    let folder = spec.out.join(fingerprint(&(&spec.command, &spec.result, names)).to_string());
    let trials: Vec<FrozenTrial> = records.keys().map(|name| FrozenTrial::of(&folder, name, &spec.result)).collect();
    for (trial, config) in trials.iter().zip(&configs) {
        if !trial.config().exists() {
            write_whole(&trial.config(), config.as_bytes())?;
        }
    }
    let index = Index { command: command.clone(), result: spec.result.clone(), trials: records };
    write_whole(&Index::path(&folder), serde_json::to_string_pretty(&index)?.as_bytes())?;
    Ok(Frozen { folder, command, trials, result: spec.result.clone() })
}
