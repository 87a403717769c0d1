//! What identification made of a model's constants.
use super::Grid;
use crate::train::{Errors, Identification};
use anyhow::Context;
use std::path::Path;

/// The constants of a stage that identified some, before and after, with the errors on both sides; `None` for other stages.
///
/// # Errors
/// When `identify.json` of the stage's folder is damaged.
pub fn identification(model: &str, folder: &Path) -> anyhow::Result<Option<Grid>> {
    let path = folder.join("identify.json");
    if !path.exists() {
        return Ok(None);
    }
    let text = std::fs::read_to_string(&path).with_context(|| format!("cannot read {}", path.display()))?;
    let found: Identification =
        serde_json::from_str(&text).with_context(|| format!("{} is damaged", path.display()))?;
    let line = |(name, c): (&String, &crate::train::Constant)| {
        let numbers = [c.before, c.after, c.low, c.high].map(|x| format!("{x:.4}"));
        let change = |beside: Option<f64>| match (beside, found.train.after) {
            (Some(beside), Some(after)) if after > 0.0 => format!("{:+.2}", 100.0 * (beside / after - 1.0)),
            _ => "–".to_owned(),
        };
        std::iter::once(name.clone()).chain(numbers).chain(c.beside.map(change)).collect()
    };
    let mut notes = vec![sentence("fitted windows", &found.train)];
    notes.push("at ±10 %: change of the error on fitted windows when this constant alone changes so much".into());
    notes.extend(found.held_out.as_ref().map(|errors| sentence("held-out windows", errors)));
    Ok(Some(Grid {
        title: format!("Identification of {model}, {} evaluations in {:.0} s", found.evaluations, found.seconds),
        header: ["constant", "before", "after", "lowest", "highest", "at −10 % [%]", "at +10 % [%]"]
            .map(String::from)
            .to_vec(),
        rows: found.constants.iter().map(line).collect(),
        notes,
    }))
}

fn sentence(of: &str, errors: &Errors) -> String {
    let millimetres = |x: Option<f64>| x.map_or("not finite".to_owned(), |x| format!("{:.3} mm", 1e3 * x));
    let (before, after, still) =
        (millimetres(errors.before), millimetres(errors.after), millimetres(Some(errors.still)));
    format!("root mean square error on {of}: {before} before, {after} after, {still} if nothing moved")
}
