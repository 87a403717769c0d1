//! Differences between attempts that met equal random numbers.
use crate::compare::Row;
use indexmap::IndexMap;

/// `a − b` in achieved cost \[m\], with its seed, for every planner, goal and seed at which both planned.
pub(super) fn paired<'a>(
    a: impl IntoIterator<Item = &'a Row>,
    b: impl IntoIterator<Item = &'a Row>,
) -> impl Iterator<Item = (u64, f64)> {
    let key = |row: &'a Row| (row.planner.as_str(), row.goal.as_str(), row.seed);
    let base: IndexMap<_, f64> = b.into_iter().filter_map(|row| Some((key(row), row.achieved?))).collect();
    a.into_iter().filter_map(move |row| Some((row.seed, row.achieved? - base.get(&key(row))?)))
}
