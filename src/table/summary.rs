//! The comparison table: one line per planner and model, intervals over seeds.
use super::paired::paired;
use super::verdict::verdict;
use super::{Grid, Interval};
use crate::compare::Row;
use crate::metric::{Better, Column, METRICS};
use indexmap::{IndexMap, IndexSet};

fn interval<'a>(rows: &[&'a Row], read: impl Fn(&'a Row) -> Option<f64>) -> Option<Interval> {
    Interval::over_seeds(rows.iter().filter_map(|row| Some((row.seed, read(row)?))))
}

fn column<'a>(rows: &[&'a Row], read: impl Fn(&'a Row) -> Option<f64>) -> String {
    Interval::millimetres(interval(rows, read))
}

/// A metric's name and how its numbers are read.
type Named = (String, Column);

/// The metrics that any row knows of: rows made before a metric was there have no column of it.
fn known(rows: &[Row]) -> Vec<Named> {
    let always = METRICS.iter().map(|metric| (metric.name().to_owned(), Column::of(*metric)));
    let mut columns: IndexMap<String, Column> = always.collect();
    columns.extend(rows.iter().flat_map(|row| row.columns.clone()));
    columns.into_iter().filter(|(name, _)| rows.iter().any(|row| row.metrics.contains_key(name))).collect()
}

/// Title of a metric's column: lengths \[m\] are printed as millimetres, shares as they are.
fn title((name, column): &Named) -> String {
    if column.unit == "m" { format!("{name} [mm]") } else { name.clone() }
}

/// A metric's cell, of numbers by metric's name.
fn cell<'a>((name, column): &Named, rows: &[&'a Row], read: impl Fn(&'a Row) -> &'a Numbers) -> String {
    let found = interval(rows, |row| read(row).get(name).copied().flatten());
    if column.unit == "m" { Interval::millimetres(found) } else { Interval::shares(found) }
}

type Numbers = IndexMap<String, Option<f64>>;

/// What `model` achieved with `planner` less what `reference` did.
fn difference(rows: &[Row], planner: &str, model: &str, reference: &str) -> Option<Interval> {
    let of = |name: &str| rows.iter().filter(|r| r.planner == planner && r.model == name).collect::<Vec<_>>();
    Interval::over_seeds(paired(of(model), of(reference)))
}

/// Models that every other is compared with, attempt by attempt: the floor and the ceiling of planning.
const REFERENCES: [&str; 2] = ["still", "oracle"];

/// The comparison table of rows, in the order in which models and planners first appear.
pub fn summary(all: &[Row]) -> Grid {
    let mut groups: IndexMap<(&str, &str), Vec<&Row>> = IndexMap::new();
    for row in all {
        groups.entry((&row.planner, &row.model)).or_default().push(row);
    }
    let mut header: Vec<String> = ["planner", "model", "planned"].map(String::from).to_vec();
    let metrics = known(all);
    header.extend(metrics.iter().map(title));
    header.extend(["cost [mm]", "predicted−achieved [mm]", "Δ start [mm]"].map(String::from));
    header.extend(REFERENCES.map(|model| format!("Δ {model} [mm]")));
    header.extend(["rollouts", "gradients", "not finite", "seconds"].map(String::from));
    let line = |(&(planner, model), rows): (&(&str, &str), &Vec<&Row>)| {
        let mut cells = vec![planner.to_owned(), model.to_owned()];
        cells.push(format!("{}/{}", rows.iter().filter(|r| r.achieved.is_some()).count(), rows.len()));
        cells.extend(metrics.iter().map(|m| cell(m, rows, |r| &r.metrics)));
        cells.push(column(rows, |r| r.achieved));
        cells.push(column(rows, |r| Some(r.predicted? - r.achieved?)));
        cells.push(column(rows, |r| Some(r.achieved? - r.start)));
        let against = |reference| difference(all, planner, model, reference);
        cells.extend(REFERENCES.map(|reference| Interval::millimetres(against(reference))));
        let mean = |read: &dyn Fn(&Row) -> f64| rows.iter().map(|r| read(r)).sum::<f64>() / rows.len() as f64;
        cells.push(format!("{:.0}", mean(&|r| r.rollouts as f64)));
        cells.push(format!("{:.0}", mean(&|r| r.gradients as f64)));
        cells.push(format!("{:.0}", rows.iter().map(|r| r.not_finite).sum::<usize>()));
        cells.push(format!("{:.2}", mean(&|r| r.seconds)));
        cells
    };
    let mut lines: Vec<Vec<String>> = groups.iter().map(line).collect();
    if all.iter().any(|row| !row.floors.is_empty()) {
        lines.push(floor_line(all, &metrics, header.len()));
    }
    Grid { title: "Comparison".into(), header, rows: lines, notes: notes(all) }
}

fn floor_line(rows: &[Row], metrics: &[Named], width: usize) -> Vec<String> {
    let rows: Vec<&Row> = rows.iter().collect();
    let mut cells = vec!["".to_owned(), "sampling floor".to_owned(), "".to_owned()];
    cells.extend(metrics.iter().map(|m| cell(m, &rows, |r| &r.floors)));
    cells.resize(width, String::new());
    cells
}

fn notes(rows: &[Row]) -> Vec<String> {
    let distinct = |read: &dyn Fn(&Row) -> String| rows.iter().map(read).collect::<IndexSet<_>>();
    let list = |read: &dyn Fn(&Row) -> String| distinct(read).into_iter().collect::<Vec<_>>().join(", ");
    let goals = list(&|r| r.goal.clone());
    let floored: IndexSet<&str> = rows.iter().filter(|r| !r.floors.is_empty()).map(|r| r.goal.as_str()).collect();
    let mut notes = vec![
        format!(
            "mean ± 95 % interval over seeds ({}), each the mean over goals ({goals}); one fit per model",
            list(&|r| r.seed.to_string())
        ),
        "Δ start: achieved cost minus that before the first action; Δ still, Δ oracle: minus what planning with that model \
         achieved, paired by goal and seed (equal random numbers); negative is better"
            .to_owned(),
    ];
    let (planners, models) = (distinct(&|r| r.planner.clone()), distinct(&|r| r.model.clone()));
    for reference in REFERENCES.iter().filter(|model| models.contains(**model)) {
        let pairs = planners.iter().flat_map(|p| models.iter().map(move |m| (p, m)));
        let others = pairs.filter(|(_, model)| !REFERENCES.contains(&model.as_str()));
        let against = |(p, m): (&String, &String)| (format!("{m} ({p})"), difference(rows, p, m, reference));
        notes.push(format!("against {reference}: {}", verdict(others.map(against))));
    }
    let known = known(rows);
    let higher = known.iter().filter(|(_, column)| column.better == Better::Higher);
    let higher = higher.map(|(name, _)| name.as_str()).collect::<Vec<_>>();
    if !higher.is_empty() {
        notes.push(format!("{}: shares, of which the higher is better", higher.join(", ")));
    }
    if !floored.is_empty() {
        let floored = floored.into_iter().collect::<Vec<_>>().join(", ");
        notes.push(format!(
            "sampling floor: the metric between two samplings of a goal that is a sampling itself ({floored})"
        ));
    }
    notes.push(format!("config {}, commit {}", list(&|r| r.fingerprint.clone()), list(&|r| r.commit.clone())));
    notes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(metrics: &str) -> Row {
        let text = format!(
            r#"{{"model":"m","planner":"p","goal":"g","seed":0,"control":"closed","tools":[],"actions":[],"predicted":0.1,
            "achieved":0.1,"start":0.2,"one_step":null,"rollout":null,"metrics":{metrics},"floors":{metrics},"rollouts":1,
            "gradients":0,"not_finite":0,"seconds":0.0,"commit":"","fingerprint":""}}"#
        );
        serde_json::from_str(&text).unwrap()
    }

    fn cell<'a>(grid: &'a Grid, line: usize, title: &str) -> Option<&'a str> {
        Some(&grid.rows[line][grid.header.iter().position(|t| t == title)?])
    }

    #[test]
    fn lengths_are_millimetres_and_shares_are_shares_that_say_which_way_is_better() {
        let grid = summary(&[row(r#"{"chamfer":0.004,"iou":0.75}"#)]);
        assert_eq!((cell(&grid, 0, "chamfer [mm]"), cell(&grid, 0, "iou")), (Some("4.00"), Some("0.75")));
        assert_eq!(cell(&grid, 1, "iou"), Some("0.75"), "the sampling floor has it too");
        assert!(grid.notes.iter().any(|note| note.starts_with("iou: shares")), "{:?}", grid.notes);
    }

    #[test]
    fn a_metric_that_a_config_added_is_read_as_its_row_says() {
        let mut added = row(r#"{"chamfer":0.004,"aligned":0.003,"iou_fine":0.75}"#);
        added.columns = serde_json::from_str(
            r#"{"aligned":{"unit":"m","better":"lower"},"iou_fine":{"unit":"","better":"higher"}}"#,
        )
        .unwrap();
        let grid = summary(&[row(r#"{"chamfer":0.004}"#), Row { model: "n".into(), ..added }]);
        assert_eq!((cell(&grid, 1, "aligned [mm]"), cell(&grid, 1, "iou_fine")), (Some("3.00"), Some("0.75")));
        assert_eq!(cell(&grid, 0, "aligned [mm]"), Some("–"), "a row that was made without it has none");
        assert!(grid.notes.iter().any(|note| note.starts_with("iou_fine: shares")), "{:?}", grid.notes);
    }

    #[test]
    fn rows_of_an_older_metric_table_have_no_column_of_a_newer_metric_and_mixed_ones_a_dash() {
        let (old, new) = (row(r#"{"chamfer":0.004}"#), Row { model: "n".into(), ..row(r#"{"iou":0.5}"#) });
        let alone = summary(std::slice::from_ref(&old));
        assert!(cell(&alone, 0, "iou").is_none() && !alone.notes.iter().any(|note| note.contains("higher")));
        let mixed = summary(&[old, new]);
        assert_eq!((cell(&mixed, 0, "iou"), cell(&mixed, 1, "iou")), (Some("–"), Some("0.50")));
        assert!(mixed.rows.iter().all(|line| line.len() == mixed.header.len()));
    }
}
