//! The rows of all trials of a sweep.
use super::freeze::Index;
use super::trial::FrozenTrial;
use anyhow::{Context, Result, anyhow};
use serde_json::Value as Json;
use std::fs;
use std::path::Path;

/// All rows of all done trials in the folder of a sweep, in the order of its plan.
///
/// A row also gets `trial` (the fingerprint), `change` (the overrides without seeds, or `baseline`) and each override's
/// key with its value; what a row says itself stays.
///
/// # Errors
/// The folder is no sweep's, or a result is not made of JSON objects, one a line.
pub fn collect(folder: &Path) -> Result<Vec<Json>> {
    let path = Index::path(folder);
    let text = fs::read(&path).with_context(|| format!("`{}` is not the folder of a sweep", folder.display()))?;
    let index: Index = serde_json::from_slice(&text).with_context(|| format!("`{}` is damaged", path.display()))?;
    let mut rows = Vec::new();
    for (name, record) in index.trials {
        let trial = FrozenTrial::of(folder, &name, &index.result);
        if !trial.done() {
            continue;
        }
        let shown = trial.result().display();
        let text = fs::read_to_string(trial.result()).with_context(|| format!("cannot read `{shown}`"))?;
        let told = [("trial".to_owned(), Json::from(name)), ("change".to_owned(), Json::from(record.change))];
        let told: Vec<(String, Json)> = told.into_iter().chain(record.overrides).collect();
        for (number, line) in text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()) {
            let damaged =
                || anyhow!("`{shown}`, line {}: not a JSON object; remove the file to run it again", number + 1);
            let mut row: Json = serde_json::from_str(line).map_err(|_| damaged())?;
            let members = row.as_object_mut().ok_or_else(damaged)?;
            for (key, value) in &told {
                members.entry(key.clone()).or_insert_with(|| value.clone());
            }
            rows.push(row);
        }
    }
    Ok(rows)
}
