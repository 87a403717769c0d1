//! The files a comparison leaves for people: tables and the report.
use super::{Curve, Grid, Picture, Report, curves, forecast, gallery, identification, report, summary};
use crate::compare::{Attempt, Comparison};
use crate::config::write_whole;
use anyhow::Context;
use serde_json::Value;
use std::path::Path;

/// Writes `table.md`, `table.tex`, `predictions.tex`, `report.html` and `gallery.html` beside the rows, and returns the two main
/// tables.
///
/// # Errors
/// A file that cannot be written, or a `metrics.jsonl` that cannot be read.
pub fn write(comparison: &Comparison, config: &str) -> anyhow::Result<Vec<Grid>> {
    let tables = vec![forecast(&comparison.predictions), summary(&comparison.rows())];
    let mut all = tables.clone();
    for (model, _, folder) in &comparison.stages {
        all.extend(identification(model, folder)?);
    }
    let folder = &comparison.folder;
    let markdown: Vec<String> = all.iter().map(Grid::to_markdown).collect();
    write_whole(&folder.join("table.md"), markdown.join("\n").as_bytes())?;
    write_whole(&folder.join("predictions.tex"), tables[0].to_latex().as_bytes())?;
    write_whole(&folder.join("table.tex"), tables[1].to_latex().as_bytes())?;
    let page = Report {
        title: "Pliant: which model should a robot plan with?".into(),
        tables: all,
        galleries: galleries(&comparison.attempts),
        plots: learning_curves(comparison)?,
        config: config.to_owned(),
    };
    write_whole(&folder.join("report.html"), report(&page).as_bytes())?;
    let pictures = gallery("Pliant: goals, and what each model made of them", &comparison.attempts);
    write_whole(&folder.join("gallery.html"), pictures.as_bytes())?;
    Ok(tables)
}

/// For every goal and planner, the first seed's start, goal and what each model achieved.
fn galleries(attempts: &[Attempt]) -> Vec<(String, Vec<Picture>)> {
    let mut galleries: Vec<(String, Vec<Picture>)> = Vec::new();
    let first_seed = |a: &&Attempt| {
        let same = attempts.iter().find(|b| b.row.goal == a.row.goal);
        same.is_some_and(|b| b.row.seed == a.row.seed)
    };
    for attempt in attempts.iter().filter(first_seed) {
        let row = &attempt.row;
        let caption = format!("goal {}, planner {}, seed {}", row.goal, row.planner, row.seed);
        if galleries.last().is_none_or(|(last, _)| *last != caption) {
            let start = Picture { title: format!("start, {:.2} mm", 1e3 * row.start), points: attempt.start.clone() };
            let goal = Picture { title: "goal".into(), points: attempt.goal.clone() };
            galleries.push((caption, vec![start, goal]));
        }
        let title = match row.achieved {
            Some(cost) => format!("{}, {:.2} mm, {}", row.model, 1e3 * cost, row.tools.join(" then ")),
            None => format!("{}: no plan", row.model),
        };
        let (_, pictures) = galleries.last_mut().expect("one was pushed above");
        pictures.push(Picture { title, points: attempt.achieved.clone() });
    }
    galleries
}

/// One plot for every stage that left a `metrics.jsonl`: each of its numbers but bookkeeping, over its first column.
fn learning_curves(comparison: &Comparison) -> anyhow::Result<Vec<String>> {
    let mut plots = Vec::new();
    for (model, stage, folder) in &comparison.stages {
        let path = folder.join("metrics.jsonl");
        if !path.exists() {
            continue;
        }
        if let Some((x, lines)) = read_curves(&path)? {
            plots.extend(curves(&format!("{model}: {stage}"), &x, "value (log scale)", &lines));
        }
    }
    Ok(plots)
}

/// Columns that say how the fit ran, not how well it fits.
const BOOKKEEPING: &[&str] = &["rate", "seconds", "gradient_norm", "evaluations", "windows", "not_finite"];

/// The name of the first column and a curve for every other number in the file.
fn read_curves(path: &Path) -> anyhow::Result<Option<(String, Vec<Curve>)>> {
    let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    let mut found: Option<(String, Vec<Curve>)> = None;
    for line in text.lines() {
        let row: Value = serde_json::from_str(line).with_context(|| format!("{} is damaged", path.display()))?;
        let Some((x, fields)) = row.as_object().and_then(|o| Some((o.iter().next()?, o.iter().skip(1)))) else {
            continue;
        };
        let (_, lines) = found.get_or_insert_with(|| (x.0.clone(), Vec::new()));
        let at = x.1.as_f64().unwrap_or(f64::NAN);
        for (name, value) in fields.filter(|(name, _)| !BOOKKEEPING.contains(&name.as_str())) {
            let Some(value) = value.as_f64() else { continue };
            match lines.iter_mut().find(|c| c.name == *name) {
                Some(curve) => curve.points.push((at, value)),
                None => lines.push(Curve { name: name.clone(), points: vec![(at, value)] }),
            }
        }
    }
    Ok(found)
}
