//! The comparison table: one line per planner and model, intervals over goals and seeds.
use super::{Grid, Interval};
use crate::compare::Row;
use crate::metric::METRICS;
use indexmap::IndexMap;

fn column<'a>(rows: &[&'a Row], read: impl Fn(&'a Row) -> Option<f64>) -> String {
    let values: Vec<f64> = rows.iter().filter_map(|row| read(row)).collect();
    Interval::millimetres(&values)
}

/// `a − b` in achieved cost \[m\] for every (goal, seed) at which both planned: equal random numbers paired.
pub fn difference(rows: &[Row], planner: &str, a: &str, b: &str) -> Vec<f64> {
    let of = |model: &str| -> IndexMap<(&str, u64), f64> {
        let mine = rows.iter().filter(|r| r.planner == planner && r.model == model);
        mine.filter_map(|r| Some(((r.goal.as_str(), r.seed), r.achieved?))).collect()
    };
    let (a, b) = (of(a), of(b));
    a.iter().filter_map(|(key, x)| Some(x - b.get(key)?)).collect()
}

/// The comparison table of rows, in the order in which models and planners first appear.
pub fn summary(all: &[Row]) -> Grid {
    let mut groups: IndexMap<(&str, &str), Vec<&Row>> = IndexMap::new();
    for row in all {
        groups.entry((&row.planner, &row.model)).or_default().push(row);
    }
    let mut header: Vec<String> = ["planner", "model", "planned"].map(String::from).to_vec();
    header.extend(METRICS.iter().map(|m| format!("{} [mm]", m.name())));
    let more =
        ["cost [mm]", "predicted−achieved [mm]", "Δ still [mm]", "rollouts", "gradients", "not finite", "seconds"];
    header.extend(more.map(String::from));
    let line = |(&(planner, model), rows): (&(&str, &str), &Vec<&Row>)| {
        let mut cells = vec![planner.to_owned(), model.to_owned()];
        cells.push(format!("{}/{}", rows.iter().filter(|r| r.achieved.is_some()).count(), rows.len()));
        cells.extend(METRICS.iter().map(|m| column(rows, |r| r.metrics.get(m.name()).copied().flatten())));
        cells.push(column(rows, |r| r.achieved));
        cells.push(column(rows, |r| Some(r.predicted? - r.achieved?)));
        cells.push(Interval::millimetres(&difference(all, planner, model, "still")));
        let mean = |read: &dyn Fn(&Row) -> f64| rows.iter().map(|r| read(r)).sum::<f64>() / rows.len() as f64;
        cells.push(format!("{:.0}", mean(&|r| r.rollouts as f64)));
        cells.push(format!("{:.0}", mean(&|r| r.gradients as f64)));
        cells.push(format!("{:.0}", rows.iter().map(|r| r.not_finite).sum::<usize>()));
        cells.push(format!("{:.2}", mean(&|r| r.seconds)));
        cells
    };
    let mut lines: Vec<Vec<String>> = groups.iter().map(line).collect();
    lines.push(floor_line(all, header.len()));
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
    let distinct = |read: &dyn Fn(&Row) -> String| {
        let mut seen: Vec<String> = rows.iter().map(read).collect();
        seen.sort();
        seen.dedup();
        seen.join(", ")
    };
    vec![
        format!("mean ± 95 % interval over goals ({}) and seeds ({})", distinct(&|r| r.goal.clone()), distinct(&|r| r.seed.to_string())),
        "Δ still: achieved cost minus that of doing nothing, paired by goal and seed (equal random numbers); negative is better".to_owned(),
        "sampling floor: the metric between two samplings of the goal itself".to_owned(),
        format!("config {}, commit {}", distinct(&|r| r.fingerprint.clone()), distinct(&|r| r.commit.clone())),
    ]
}
