//! A trained network's law, read back as a formula.
use super::alone::fit_to;
use super::contender::read_fitted;
use super::{Contender, ContenderSpec};
use crate::config;
use crate::train::FitSpec;
use crate::train::distil::{Candidate, DistilSpec, FRONT};
use crate::watch::Watch;
use anyhow::{Context, ensure};
use indexmap::IndexMap;
use std::path::Path;

/// Fits the model that the file `model` and `overrides` of its keys describe to the dataset in `folder`, as [`super::train`] does,
/// and distils it where its config does not; `model` may also be the folder of a stage that an earlier run fitted.
///
/// # Errors
/// As [`super::train`]; when the model has not one learned pair law.
pub fn distil(
    model: &Path,
    overrides: &[String],
    folder: &Path,
    root: &Path,
    watch: &Watch,
) -> anyhow::Result<(Contender, Vec<Candidate>)> {
    let mut spec = match read_fitted(model)? {
        Some(dynamics) => {
            ensure!(overrides.is_empty(), "{} is fitted already; {overrides:?} cannot change it", model.display());
            ContenderSpec { train: IndexMap::new(), adapt: IndexMap::new(), dynamics }
        }
        None => config::load::<ContenderSpec>(model, overrides)?.spec,
    };
    if !spec.train.values().any(|stage| matches!(stage, FitSpec::Distil(_))) {
        spec.train.insert("distil".to_owned(), FitSpec::Distil(DistilSpec::default()));
    }
    let contender = fit_to(&spec, model, folder, root, watch)?;
    let stages = spec.train.values().zip(contender.stages.values());
    let distilled = stages.filter(|(stage, _)| matches!(stage, FitSpec::Distil(_)));
    let candidates = distilled.map(|(_, folder)| read(folder)).collect::<anyhow::Result<Vec<_>>>()?.concat();
    Ok((contender, candidates))
}

fn read(folder: &Path) -> anyhow::Result<Vec<Candidate>> {
    let path = folder.join(FRONT);
    let text = std::fs::read_to_string(&path).with_context(|| format!("cannot read {}", path.display()))?;
    let lines = text.lines().map(serde_json::from_str).collect::<Result<_, _>>();
    lines.with_context(|| format!("{} is damaged; delete its folder to distil again", path.display()))
}
