//! A claim of the paper: a sweep that tests it, and the table its rows make.
use crate::peer::Peer;
use anyhow::Context;
use pliant::compare::{CompareSpec, Row, commit, compare};
use pliant::config;
use pliant::sweep::{self, SweepSpec};
use pliant::table::{Grid, Interval, TrialRow};
use pliant::watch::Watch;
use serde_json::Value;
use std::fmt;
use std::path::{Path, PathBuf};

/// One claim and everything needed to test it.
pub(crate) struct Experiment {
    /// Name on the command line and of its files.
    pub(crate) name: &'static str,
    /// What is claimed; the table says whether it holds.
    pub(crate) claim: &'static str,
    /// Wall time on two cores, after the build.
    pub(crate) duration: &'static str,
    /// Where its rows come from.
    pub(crate) rows: Rows,
    /// Turns rows into the table.
    pub(crate) table: fn(&[Value]) -> anyhow::Result<Grid>,
}

/// Where the rows of an experiment come from.
pub(crate) enum Rows {
    /// A sweep, which resumes where it was cut short.
    Sweep {
        /// Its config.
        config: &'static str,
        /// Overrides that make the fits of its models tiny.
        smoke: &'static [&'static str],
    },
    /// A function that measures them anew.
    Measured(Measure),
    /// A function that measures them anew beside another project's program; `python=PATH` names the interpreter that runs it.
    Beside(fn(Size, &Peer, &Watch) -> anyhow::Result<Vec<Value>>),
    /// A function that measures them anew on recordings of others; `recordings=PATH` names their folder.
    Recorded(Measure),
}

/// Makes rows, and figures below a folder.
pub(crate) type Measure = fn(Size, &Path, &Watch) -> anyhow::Result<Vec<Value>>;

/// How much of an experiment to run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Size {
    /// What the paper reports.
    Paper,
    /// The same path through the code in seconds; its numbers mean nothing.
    Smoke,
}

/// What makes any comparison tiny; experiments add what makes their fits tiny.
const SMOKE: &[&str] = &["dataset=smoke", "seeds=[0]", "goal=[pressed]", "budget.rollouts=4"];

/// What makes the fits of the analytical, the learned and the hybrid model tiny.
pub(crate) const SMALL_FITS: &[&str] = &[
    "model.analytic.train.identify.evaluations=12",
    "model.learned.train.network.steps=4",
    "model.hybrid.train.identify.evaluations=12",
    "model.hybrid.train.residual.steps=4",
];

/// What `key=VALUE` among `words` gives, else `default`.
///
/// # Errors
/// When a word is another one.
pub(crate) fn chosen(words: &[String], key: &str, default: &str) -> anyhow::Result<String> {
    let mut value = default.to_owned();
    for word in words {
        let given = word.strip_prefix(key).and_then(|rest| rest.strip_prefix('='));
        value = given.with_context(|| format!("`{word}` means nothing here; there is {key}=PATH"))?.to_owned();
    }
    Ok(value)
}

/// The number under `key`, which is none where there is none.
pub(crate) fn number(row: &Value, key: &str) -> f64 {
    row[key].as_f64().unwrap_or(f64::NAN)
}

/// The middle of a list of numbers, of two the mean.
pub(crate) fn median(mut numbers: Vec<f64>) -> f64 {
    numbers.sort_by(f64::total_cmp);
    let half = numbers.len() / 2;
    match numbers.len() {
        0 => f64::NAN,
        n if n % 2 == 0 => 0.5 * (numbers[half - 1] + numbers[half]),
        _ => numbers[half],
    }
}

/// The word of a table for whether a claim holds.
pub(crate) fn verdict(holds: bool) -> &'static str {
    if holds { "holds" } else { "fails" }
}

/// The same of what is claimed of a number that is NaN where nobody measured it.
pub(crate) fn verdict_on(measured: f64, holds: bool) -> &'static str {
    if measured.is_nan() { "not measured" } else { verdict(holds) }
}

/// The list that a change such as `key=["a", "b"]` sets, as `a, b`; none of the baseline.
pub(crate) fn listed(change: &str) -> Option<String> {
    let (_, list) = change.split_once('=')?;
    Some(list.replace(['[', ']', '"', '\''], "").replace(',', ", ").replace("  ", " "))
}

/// What a change such as `key=value` sets, or `key=value other=value` alike; of the baseline what its own value is.
pub(crate) fn changed(change: &str, baseline: &str) -> String {
    let first = change.split(' ').next().and_then(|one| one.split_once('='));
    first.map_or_else(|| baseline.to_owned(), |(_, value)| value.to_owned())
}

/// The rows that a sweep collected.
pub(crate) fn trials(rows: &[Value]) -> anyhow::Result<Vec<TrialRow>> {
    rows.iter().map(TrialRow::read).collect()
}

/// The rows of the comparison in `configs/compare` of this name, with these words on its command line.
pub(crate) fn compared(name: &str, words: &[String], watch: &Watch) -> anyhow::Result<Vec<Value>> {
    let loaded = config::load::<CompareSpec>(format!("configs/compare/{name}.toml").as_ref(), words)?;
    Ok(compare(&loaded, &commit(), watch)?.rows().iter().map(serde_json::to_value).collect::<Result<_, _>>()?)
}

/// Achieved cost of `mine` minus that of `reference`, paired by goal and seed \[m\].
pub(crate) fn difference(mine: &[&Row], reference: &[&Row]) -> Option<Interval> {
    difference_of(|row| row.achieved, mine, reference)
}

/// A number of `mine` minus that of `reference`, paired by goal and seed.
pub(crate) fn difference_of(
    value: impl Fn(&Row) -> Option<f64>,
    mine: &[&Row],
    reference: &[&Row],
) -> Option<Interval> {
    paired(value, 1.0, mine, reference)
}

/// A number of `mine` minus so many times that of `reference`, likewise.
pub(crate) fn paired(
    value: impl Fn(&Row) -> Option<f64>,
    times: f64,
    mine: &[&Row],
    reference: &[&Row],
) -> Option<Interval> {
    paired_by(|row| (row.goal.as_str(), row.seed), value, times, mine, reference)
}

/// Achieved cost of `mine` minus that of `reference`, paired by planner, goal and seed \[m\].
pub(crate) fn by_planner(mine: &[&Row], reference: &[&Row]) -> Option<Interval> {
    paired_by(|row| (row.planner.as_str(), row.goal.as_str(), row.seed), |row| row.achieved, 1.0, mine, reference)
}

/// A number of `mine` minus so many times that of the row of `reference` with the same key.
fn paired_by<'a, K: PartialEq>(
    key: impl Fn(&'a Row) -> K,
    value: impl Fn(&Row) -> Option<f64>,
    times: f64,
    mine: &[&'a Row],
    reference: &[&'a Row],
) -> Option<Interval> {
    Interval::over_seeds(mine.iter().filter_map(|row| {
        let other = reference.iter().find(|other| key(other) == key(row))?;
        Some((row.seed, value(row)? - times * value(other)?))
    }))
}

impl Experiment {
    /// Makes the rows and writes `data/NAME.jsonl` and `tables/NAME.tex` below `out`.
    pub(crate) fn run(&self, size: Size, words: &[String], out: &Path, watch: &Watch) -> anyhow::Result<Grid> {
        let rows = match &self.rows {
            Rows::Measured(measure) => {
                anyhow::ensure!(words.is_empty(), "{} has nothing to change, but was given {words:?}", self.name);
                measure(size, out, watch)?
            }
            Rows::Beside(measure) => measure(size, &Peer::named(words)?, watch)?,
            Rows::Recorded(measure) => {
                let folder = chosen(words, "recordings", "../shared/data/boxbath")?;
                measure(size, folder.as_ref(), watch)?
            }
            Rows::Sweep { config, smoke } => {
                let mut spec = config::load::<SweepSpec>(Path::new(config), words)?.spec;
                if size == Size::Smoke {
                    let elsewhere = |change: &&mut Vec<String>| change.iter().any(|word| word.starts_with("dataset="));
                    spec.changes
                        .iter_mut()
                        .filter(elsewhere)
                        .for_each(|change| change.push("dataset.episodes=6".into()));
                    spec.seeds.truncate(1);
                    spec.set.extend(SMOKE.iter().chain(*smoke).map(|change| (*change).to_owned()));
                }
                let outcome = sweep::run::<CompareSpec>(&spec, watch)?;
                outcome.complete(watch)?;
                sweep::collect(&outcome.folder)?
            }
        };
        let grid = (self.table)(&rows)?;
        let lines: String = rows.iter().map(|row| format!("{row}\n")).collect();
        config::write_whole(&self.place(out, "data", "jsonl"), lines.as_bytes())?;
        config::write_whole(&self.place(out, "tables", "tex"), grid.to_latex().as_bytes())?;
        Ok(grid)
    }

    /// Writes the table that the committed rows give.
    pub(crate) fn tabulate(&self, paper: &Path) -> anyhow::Result<()> {
        config::write_whole(&self.place(paper, "tables", "tex"), self.committed(paper)?.to_latex().as_bytes())
    }

    /// Fails when the committed table is not what the committed rows give.
    pub(crate) fn check(&self, paper: &Path) -> anyhow::Result<()> {
        let same = read(&self.place(paper, "tables", "tex"))? == self.committed(paper)?.to_latex();
        anyhow::ensure!(
            same,
            "paper/tables/{0}.tex is not what paper/data/{0}.jsonl gives; run `experiments tables`",
            self.name
        );
        println!("{}: the table is what its rows give", self.name);
        Ok(())
    }

    fn committed(&self, paper: &Path) -> anyhow::Result<Grid> {
        let text = read(&self.place(paper, "data", "jsonl"))
            .with_context(|| format!("make the rows by `experiments {}`", self.name))?;
        (self.table)(&text.lines().map(serde_json::from_str).collect::<Result<Vec<_>, _>>()?)
    }

    fn place(&self, paper: &Path, folder: &str, extension: &str) -> PathBuf {
        paper.join(folder).join(self.name).with_extension(extension)
    }
}

/// The text of a file.
pub(crate) fn read(path: &Path) -> anyhow::Result<String> {
    std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))
}

impl fmt::Display for Experiment {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}: {}", self.name, self.claim)?;
        writeln!(f, "    cargo run --release --bin experiments -- {}    ({})", self.name, self.duration)?;
        write!(f, "    paper/data/{0}.jsonl → paper/tables/{0}.tex", self.name)
    }
}
