//! The table of a sweep: one line per change and model.
use super::paired::paired;
use super::verdict::verdict;
use super::{Grid, Interval};
use crate::compare::Row;
use indexmap::IndexMap;
use std::collections::BTreeMap;

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

/// One line per (change, model): held-out prediction error, achieved cost, and the paired difference to a reference line; where every
/// seed has a fit of its own, also which changes predict better than their reference.
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
    let base = |(change, model)| groups.get(&reference(change, model)).into_iter().flatten().copied();
    let difference = |key, mine: &[&'a Row]| Interval::over_seeds(paired(mine.iter().copied(), base(key)));
    // Differences of fits of equal seeds, where there are several.
    let prediction = |key, mine: &[&Row], of: fn(&Row) -> Option<f64>| {
        let base: BTreeMap<u64, f64> = base(key).filter_map(|row| Some((row.seed, of(row)?))).collect();
        let paired = mine.iter().filter_map(|row| Some((row.seed, of(row)? - base.get(&row.seed)?)));
        Interval::over_seeds(paired)
    };
    let own = |(change, model): (&'a str, &'a str)| (change, model) == reference(change, model);
    let line = |(&(change, model), mine): (&(&'a str, &'a str), &Vec<&'a Row>)| {
        let error = |of: fn(&Row) -> Option<f64>| match repeated(mine) {
            true => Interval::millimetres(Interval::over_seeds(mine.iter().filter_map(|r| Some((r.seed, of(r)?))))),
            false => of(mine[0]).map_or("–".to_owned(), |x| format!("{:.2}", 1e3 * x)),
        };
        let achieved = Interval::over_seeds(mine.iter().filter_map(|r| Some((r.seed, r.achieved?))));
        let delta = match own((change, model)) {
            true => "reference".to_owned(),
            false => Interval::millimetres(difference((change, model), mine)),
        };
        vec![
            name(change),
            model.to_owned(),
            error(|row| row.one_step),
            error(|row| row.rollout),
            Interval::millimetres(achieved),
            delta,
            mine.len().to_string(),
        ]
    };
    let others = groups.iter().filter(|(key, _)| !own(**key));
    let named: Vec<_> = others.map(|(key, mine)| (format!("{} / {}", name(key.0), key.1), *key, mine)).collect();
    let achieved = named.iter().map(|(label, key, mine)| (label.clone(), difference(*key, mine)));
    let several = groups.values().any(|mine| repeated(mine));
    let fits = if several { "mean ± 95 % interval over fits, one a seed" } else { "one fit each" };
    let mut notes = vec![
        format!("one step, rollout: root mean square error on held-out episodes, {fits}"),
        "achieved: mean ± 95 % interval over seeds, each the mean over goals and planners; Δ reference: minus the reference \
         of the same block, paired by goal, planner and seed; negative is better"
            .to_owned(),
        format!("achieved cost against the reference: {}", verdict(achieved)),
    ];
    if several {
        let mut compare = |what: &str, of: fn(&Row) -> Option<f64>| {
            let predicted = named.iter().map(|(label, key, mine)| (label.clone(), prediction(*key, mine, of)));
            notes.push(format!("{what} error against the reference, paired by seed: {}", verdict(predicted)));
        };
        compare("one-step", |row| row.one_step);
        compare("rollout", |row| row.rollout);
    }
    Grid {
        title: title.to_owned(),
        header: header.map(String::from).to_vec(),
        rows: groups.iter().map(line).collect(),
        notes,
    }
}

/// Whether the rows are of several fits.
fn repeated(rows: &[&Row]) -> bool {
    rows.iter().any(|row| row.rollout != rows[0].rollout)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn trial(change: &str, seed: u64, rollout: f64) -> TrialRow {
        let row = json!({ "change": change, "model": "learned", "planner": "cem", "goal": "disc", "seed": seed, "control": "open",
            "tools": [], "actions": [], "predicted": null, "achieved": 0.008, "start": 0.01, "one_step": 0.5 * rollout,
            "rollout": rollout, "metrics": {}, "floors": {}, "rollouts": 1, "gradients": 0, "not_finite": 0, "seconds": 0.0,
            "commit": "", "fingerprint": "" });
        TrialRow::read(&row).unwrap()
    }

    fn table(rows: &[TrialRow]) -> Grid {
        ablation("", rows, str::to_owned, |_, model| ("baseline", model))
    }

    #[test]
    fn fits_of_equal_seeds_are_compared_whatever_differs_between_seeds() {
        let pairs = [("baseline", 0.0), ("better", -1e-3)];
        // Seeds differ by far more than the change does.
        let rows = pairs.map(|(change, less)| (1..=3).map(move |seed| trial(change, seed, 0.01 * seed as f64 + less)));
        let grid = table(&rows.into_iter().flatten().collect::<Vec<_>>());
        assert_eq!(grid.rows[0][2], "10.00 ± 12.42", "t₀.₉₇₅(2) = 4.303 times 5 mm over √3");
        for (note, what) in grid.notes[3..].iter().zip(["one-step", "rollout"]) {
            assert!(note.starts_with(what) && note.ends_with("lower: better / learned"), "{note}");
        }
    }

    #[test]
    fn one_fit_has_no_interval_and_decides_nothing() {
        let rows: Vec<_> =
            (1..=3).flat_map(|seed| [trial("baseline", seed, 0.01), trial("worse", seed, 0.02)]).collect();
        let grid = table(&rows);
        assert_eq!([&grid.rows[0][3], &grid.rows[1][3]], ["10.00", "20.00"]);
        assert_eq!(grid.notes.len(), 3, "nothing is said of predictions");
    }
}
