//! What rows say of a claim, line by line: it holds, it fails, or it is not shown.
use crate::claim::{difference_of, paired};
use indexmap::IndexSet;
use pliant::compare::Row;
use pliant::table::{Interval, TrialRow};

/// A cost or an error up to so many times another counts as no worse: that two are equal can never be shown.
pub(crate) const NO_WORSE: f64 = 1.1;
/// Who has no model, and who has the world itself.
pub(crate) const NOBODY: &str = "still";
pub(crate) const WORLD: &str = "oracle";

/// Whether a difference lies below zero; none where its interval holds zero, or where it is unknown.
pub(crate) fn lower(difference: Option<Interval>) -> Option<bool> {
    let Interval { mean, half, .. } = difference?;
    (mean.abs() > half).then_some(mean < 0.0)
}

/// Whether a number is at most another; none where nobody measured it.
pub(crate) fn at_most(measured: f64, most: f64) -> Option<bool> {
    (!measured.is_nan()).then_some(measured <= most)
}

/// The note on a claim that is made of every one of these lines.
pub(crate) fn adjudge(what: &str, lines: impl IntoIterator<Item = (String, Option<bool>)>) -> String {
    let lines: Vec<(String, Option<bool>)> = lines.into_iter().collect();
    let of = |said: Option<bool>| lines.iter().filter(|line| line.1 == said).map(|line| line.0.as_str()).collect();
    let [fails, open, holds]: [Vec<&str>; 3] = [Some(false), None, Some(true)].map(of);
    let said = match (holds.len(), lines.len()) {
        (_, 0) => "not measured".to_owned(),
        (1, 1) => "holds".to_owned(),
        (some, all) if some == all => format!("holds on all {all} lines"),
        (some, all) => {
            let named = [("fails", fails), ("not shown", open)].into_iter().filter(|(_, labels)| !labels.is_empty());
            let mut said: Vec<String> = named.map(|(word, labels)| format!("{word} ({})", labels.join("; "))).collect();
            if some > 0 {
                said.push(format!("holds on {some} of {all} lines"));
            }
            said.join("; ")
        }
    };
    format!("claim, {what}: {said}")
}

/// An error of prediction, and what it is called.
pub(crate) type Error = (&'static str, fn(&Row) -> Option<f64>);

pub(crate) const ONE_STEP: Error = ("one-step error", |row| row.one_step);
pub(crate) const ROLLOUT: Error = ("rollout error", |row| row.rollout);

/// An error of `mine` minus so many times that of `reference`, paired by seed. Seeds that planned with one fit each have no spread of
/// their own, and so no interval.
pub(crate) fn predicted((_, error): Error, times: f64, mine: &[&Row], reference: &[&Row]) -> Option<Interval> {
    let interval = paired(error, times, mine, reference)?;
    let once = |rows: &[&Row]| rows.iter().all(|row| error(row) == error(rows[0]));
    Some(if once(mine) && once(reference) { Interval { half: f64::INFINITY, count: 1, ..interval } } else { interval })
}

/// The rows of those trials that are asked for.
pub(crate) fn rows_of(trials: &[TrialRow], wanted: impl Fn(&TrialRow) -> bool) -> Vec<&Row> {
    trials.iter().filter(|trial| wanted(trial)).map(|trial| &trial.row).collect()
}

/// The note on a claim that, of each pair of variants, the first errs less than so many times the second.
pub(crate) fn errs_less(
    what: &str,
    error: Error,
    times: f64,
    trials: &[TrialRow],
    name: impl Fn(&str) -> String,
    pairs: &[[&str; 2]],
) -> String {
    let line = |pair: &[&str; 2]| {
        let [mine, reference] = pair.map(|variant| rows_of(trials, |trial| name(&trial.change) == variant));
        (format!("{} against {}", pair[0], pair[1]), lower(predicted(error, times, &mine, &reference)))
    };
    adjudge(&format!("{what}, {}", error.0), pairs.iter().map(line))
}

/// The notes on claims that whoever plans achieves less cost than a model in which nothing moves, and the simulator least.
pub(crate) fn between(rows: &[Row]) -> [String; 2] {
    let keys: IndexSet<(&str, &str)> = rows.iter().map(|row| (row.planner.as_str(), row.model.as_str())).collect();
    let of = |planner: &str, model: &str| -> Vec<&Row> {
        rows.iter().filter(|row| row.planner == planner && row.model == model && row.achieved.is_some()).collect()
    };
    let against = |less: fn(&str, &str) -> [String; 2], others: &[&str]| {
        let asked = keys.iter().filter(|(_, model)| !others.contains(model));
        let line = |(planner, model): &(&str, &str)| {
            let [mine, reference] = less(model, others[0]).map(|model| of(planner, &model));
            let both = !mine.is_empty() && !reference.is_empty();
            both.then(|| (format!("{model} ({planner})"), lower(difference_of(|row| row.achieved, &mine, &reference))))
        };
        asked.filter_map(line).collect::<Vec<_>>()
    };
    [
        adjudge(
            "every model that plans achieves less cost than still",
            against(|model, still| [model, still].map(str::to_owned), &[NOBODY]),
        ),
        adjudge(
            "the simulator achieves less cost than every model",
            against(|model, world| [world, model].map(str::to_owned), &[WORLD, NOBODY]),
        ),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_claim_holds_where_an_interval_lies_below_zero_and_fails_where_it_lies_above() {
        let of = |values: &[f64]| lower(Interval::of(values));
        assert_eq!([of(&[-1.0, -0.2]), of(&[]), of(&[-1.0])], [None; 3], "zero lies within, nothing, one number");
        assert_eq!([of(&[-1.0, -1.01, -0.99]), of(&[1.0, 1.01, 0.99])], [Some(true), Some(false)]);
    }

    #[test]
    fn a_note_names_the_lines_on_which_a_claim_does_not_hold() {
        let line = |label: &str, said| (label.to_owned(), said);
        let all = [line("a", Some(true)), line("b", None), line("c", Some(false)), line("d", Some(true))];
        assert_eq!(adjudge("less", all.clone()), "claim, less: fails (c); not shown (b); holds on 2 of 4 lines");
        assert_eq!(adjudge("less", all[..1].to_vec()), "claim, less: holds");
        assert_eq!(adjudge("less", all[1..2].to_vec()), "claim, less: not shown (b)");
        assert_eq!(adjudge("less", []), "claim, less: not measured");
    }
}
