//! The table of a sweep: one line per change and model.
use super::paired::paired;
use super::verdict::verdict;
use super::{Grid, Interval};
use crate::compare::Row;
use indexmap::IndexMap;

/// One row of a sweep: the attempt, and which trial made it.
#[derive(Clone, Debug, PartialEq)]
pub struct TrialRow {
    /// The overrides that lead from the base to the trial, or `baseline`.
    pub change: String,
    /// The attempt.
    pub row: Row,
}

impl TrialRow {
    /// Reads what a sweep collected: a row with the extra field `change`.
    ///
    /// # Errors
    /// When it is not a result row.
    pub fn read(value: &serde_json::Value) -> anyhow::Result<Self> {
        let change = value.get("change").and_then(|c| c.as_str()).unwrap_or("baseline").to_owned();
        Ok(Self { change, row: serde_json::from_value(value.clone())? })
    }
}

/// One line per (change, model): held-out prediction error, achieved cost, and the paired difference to a reference line.
///
/// `name` turns a change into what the table calls it; `reference` gives the (change, model) that a line is compared with,
/// attempt by attempt (same planner, goal and seed).
pub fn ablation<'a>(
    title: &str,
    rows: &'a [TrialRow],
    name: impl Fn(&str) -> String,
    reference: impl Fn(&'a str, &'a str) -> (&'a str, &'a str),
) -> Grid {
    let mut groups: IndexMap<(&str, &str), Vec<&Row>> = IndexMap::new();
    for TrialRow { change, row } in rows {
        groups.entry((change, &row.model)).or_default().push(row);
    }
    let header = ["variant", "model", "one step [mm]", "rollout [mm]", "achieved [mm]", "Δ reference [mm]", "attempts"];
    let difference = |(change, model), mine: &[&Row]| {
        let base: &[&Row] = groups.get(&reference(change, model)).map_or(&[], |g| g);
        Interval::over_seeds(paired(mine.iter().copied(), base.iter().copied()))
    };
    let own = |(change, model): (&'a str, &'a str)| (change, model) == reference(change, model);
    let line = |(&(change, model), mine): (&(&'a str, &'a str), &Vec<&Row>)| {
        let millimetres = |x: Option<f64>| x.map_or("–".to_owned(), |x| format!("{:.2}", 1e3 * x));
        let achieved = Interval::over_seeds(mine.iter().filter_map(|r| Some((r.seed, r.achieved?))));
        let delta = match own((change, model)) {
            true => "reference".to_owned(),
            false => Interval::millimetres(difference((change, model), mine)),
        };
        vec![
            name(change),
            model.to_owned(),
            millimetres(mine[0].one_step),
            millimetres(mine[0].rollout),
            Interval::millimetres(achieved),
            delta,
            mine.len().to_string(),
        ]
    };
    let others = groups.iter().filter(|(key, _)| !own(**key));
    let others = others.map(|(key, mine)| (format!("{} / {}", name(key.0), key.1), difference(*key, mine)));
    let notes = vec![
        "one step, rollout: root mean square error on held-out episodes, one fit each".to_owned(),
        "achieved: mean ± 95 % interval over seeds, each the mean over goals and planners; Δ reference: minus the reference \
         of the same block, paired by goal, planner and seed; negative is better"
            .to_owned(),
        format!("achieved cost against the reference: {}", verdict(others)),
    ];
    Grid {
        title: title.to_owned(),
        header: header.map(String::from).to_vec(),
        rows: groups.iter().map(line).collect(),
        notes,
    }
}
