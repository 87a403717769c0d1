//! Sweeps: many trials of one command, each with its own frozen config, run once whatever happens in between.
//!
//! The folder of a sweep is `<out>/<fingerprint of all its trials>`, the folder of a trial in it is named by the
//! fingerprint of its resolved config: another base file, another grid or another command is another sweep, while other
//! `jobs` or the same configs written otherwise continue the old one.
mod collect;
mod freeze;
mod launch;
mod plan;
mod trial;

use crate::config::Spec;
use crate::watch::Watch;
use anyhow::Result;
use indexmap::IndexMap;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

pub use collect::collect;
pub use freeze::{Frozen, freeze};
pub use launch::{Outcome, launch};
pub use plan::{Trial, plan};
pub use trial::FrozenTrial;

/// What to run, on which configs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SweepSpec {
    /// The words of the command, which also gets `<trial>/config.toml out=<trial>`; empty stands for
    /// `pliant compare`, the program beside this one.
    #[serde(default)]
    pub command: Vec<String>,
    /// The config file that every trial starts from, relative to the current folder.
    pub base: PathBuf,
    /// Overrides that every trial begins with.
    #[serde(default)]
    pub set: Vec<String>,
    /// Key → values: every combination is a trial, the last key varying fastest.
    #[serde(default)]
    pub grid: IndexMap<String, Vec<serde_json::Value>>,
    /// Lists of overrides, tried one list at a time against the baseline without any of them.
    #[serde(default)]
    pub changes: Vec<Vec<String>>,
    /// Seeds to repeat every trial with, each given to it as `seeds=[s]`; none leaves the seeds of the base.
    #[serde(default)]
    pub seeds: Vec<u64>,
    /// Further keys that are given each of the seeds, such as those of a fit, so that repetitions share nothing.
    #[serde(default)]
    pub seeded: Vec<String>,
    /// Trials running at once.
    #[serde(default = "one")]
    #[schemars(range(min = 1, max = 4096))]
    pub jobs: usize,
    /// The file in a trial's folder that marks it as done, holding its rows.
    #[serde(default = "rows")]
    pub result: String,
    /// The folder that sweeps are kept in.
    #[serde(default = "runs")]
    pub out: PathBuf,
}

fn one() -> usize {
    1
}

fn rows() -> String {
    "rows.jsonl".to_owned()
}

fn runs() -> PathBuf {
    PathBuf::from("runs/sweep")
}

/// Freezes every trial of a sweep over configs of type `T`, then runs those that are not done.
///
/// # Errors
/// A trial's config is wrong (nothing is written then), or a file cannot be written. A trial that fails is no error: it
/// is counted, described in its `failure.json`, and tried again by the next run.
pub fn run<T: Spec>(spec: &SweepSpec, watch: &Watch) -> Result<Outcome> {
    launch(&freeze::<T>(spec)?, spec.jobs, watch)
}
