//! The comparison table: one line per planner and model, intervals over seeds.
use super::paired::paired;
use super::verdict::verdict;
use super::{Grid, Interval};
use crate::compare::Row;
use crate::metric::METRICS;
use indexmap::{IndexMap, IndexSet};

fn column<'a>(rows: &[&'a Row], read: impl Fn(&'a Row) -> Option<f64>) -> String {
    Interval::millimetres(Interval::over_seeds(rows.iter().filter_map(|row| Some((row.seed, read(row)?)))))
}

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
    header.extend(METRICS.iter().map(|m| format!("{} [mm]", m.name())));
    header.extend(["cost [mm]", "predicted−achieved [mm]", "Δ start [mm]"].map(String::from));
    header.extend(REFERENCES.map(|model| format!("Δ {model} [mm]")));
    header.extend(["rollouts", "gradients", "not finite", "seconds"].map(String::from));
    let line = |(&(planner, model), rows): (&(&str, &str), &Vec<&Row>)| {
        let mut cells = vec![planner.to_owned(), model.to_owned()];
        cells.push(format!("{}/{}", rows.iter().filter(|r| r.achieved.is_some()).count(), rows.len()));
        cells.extend(METRICS.iter().map(|m| column(rows, |r| r.metrics.get(m.name()).copied().flatten())));
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
        lines.push(floor_line(all, header.len()));
    }
    Grid { title: "Comparison".into(), header, rows: lines, notes: notes(all) }
}

fn floor_line(rows: &[Row], width: usize) -> Vec<String> {
    let rows: Vec<&Row> = rows.iter().collect();
    let mut cells = vec!["".to_owned(), "sampling floor".to_owned(), "".to_owned()];
    cells.extend(METRICS.iter().map(|m| column(&rows, |r| r.floors.get(m.name()).copied().flatten())));
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
    if !floored.is_empty() {
        let floored = floored.into_iter().collect::<Vec<_>>().join(", ");
        notes.push(format!(
            "sampling floor: the metric between two samplings of a goal that is a sampling itself ({floored})"
        ));
    }
    notes.push(format!("config {}, commit {}", list(&|r| r.fingerprint.clone()), list(&|r| r.commit.clone())));
    notes
}
