//! Claim: for equally many rollouts, descending along a model's exact gradient, and sampling first and then descending, find plans that
//! the model promises more of than sampling alone does, whatever the budget.
//!
//! Command: `cargo run --release --bin experiments -- gradients`, about fifteen minutes. Table: `paper/tables/gradients.tex`.
use crate::adjudge::{adjudge, lower};
use crate::claim::{Experiment, Rows, SMALL_FITS, Size, compared, difference, difference_of, median};
use indexmap::IndexSet;
use pliant::compare::Row;
use pliant::table::{Grid, Interval, verdict};
use pliant::watch::Watch;
use serde_json::{Value, json};
use std::path::Path;

pub(crate) const CLAIM: Experiment = Experiment {
    name: "gradients",
    claim: "exact gradients, alone or after sampling, find plans of lower predicted cost than sampling for every number of rollouts",
    duration: "about 15 minutes",
    rows: Rows::Measured(measure),
    table,
};

/// Sizes with which each search spends a budget, of which a gradient takes three rollouts.
struct Sizes {
    rollouts: usize,
    /// Plans a round, elites, rounds.
    cem: [usize; 3],
    /// Candidates, starts, steps: `c − 1 + 3sk + s` rollouts, without the candidates where no start is chosen among them.
    descent: [usize; 3],
    /// Plans a round, rounds, steps: `3 + nr + 3k + 1` rollouts, the first three to ask whether there is a gradient.
    refine: [usize; 3],
}

const SIZES: [Sizes; 4] = [
    Sizes { rollouts: 10, cem: [5, 2, 2], descent: [1, 1, 3], refine: [3, 1, 1] },
    Sizes { rollouts: 20, cem: [5, 2, 4], descent: [2, 2, 3], refine: [7, 1, 3] },
    Sizes { rollouts: 40, cem: [10, 3, 4], descent: [4, 2, 6], refine: [10, 2, 5] },
    Sizes { rollouts: 80, cem: [10, 3, 8], descent: [4, 3, 8], refine: [10, 4, 12] },
];
/// The budget at which the simulator, and a model in which nothing moves, plan too, by samples.
const FLOORS: usize = 40;
/// Each goal, and the tool that it was made with.
const GOALS: [(&str, &str); 2] = [("pressed", "press_square"), ("gripped", "gripper_rod")];
const SMOKE: [&str; 2] = ["dataset=smoke", "seeds=[0]"];
/// What every search is compared with.
const REFERENCE: &str = "cem";

impl Sizes {
    /// What they are in the config.
    fn words(&self) -> Vec<String> {
        let Self { rollouts, cem: [n, elites, rounds], descent: [candidates, starts, steps], refine: [m, times, last] } =
            self;
        let words = [
            format!("budget.rollouts={rollouts}"),
            format!("planner.cem.samples={n}"),
            format!("planner.cem.fewest={n}"),
            format!("planner.cem.elites={elites}"),
            format!("planner.cem.rounds={rounds}"),
            format!("planner.descent.candidates={candidates}"),
            format!("planner.descent.starts={starts}"),
            format!("planner.descent.steps={steps}"),
            format!("planner.refine.search.samples={m}"),
            format!("planner.refine.search.fewest={m}"),
            format!("planner.refine.search.elites={}", 2.max(m / 3)),
            format!("planner.refine.search.rounds={times}"),
            format!("planner.refine.descent.steps={last}"),
        ];
        words.to_vec()
    }
}

fn measure(size: Size, _: &Path, watch: &Watch) -> anyhow::Result<Vec<Value>> {
    let (sizes, goals, smoke) = match size {
        Size::Paper => (&SIZES[..], &GOALS[..], Vec::new()),
        Size::Smoke => (&SIZES[..1], &GOALS[..1], [&SMOKE[..], SMALL_FITS].concat()),
    };
    let mut rows = Vec::new();
    for (size, (goal, tool)) in sizes.iter().flat_map(|size| goals.iter().map(move |goal| (size, goal))) {
        let mut words = size.words();
        words.extend(smoke.iter().map(|word| (*word).to_owned()));
        words.extend([format!("goal=[{goal}]"), format!("chooser.tool={tool}")]);
        let floors = ["model=[oracle, still]", "~planner.descent", "~planner.refine"].map(str::to_owned);
        let mut runs = vec![words.clone()];
        if size.rollouts == FLOORS {
            runs.push([&words[..], &floors].concat());
        }
        for words in runs {
            for mut row in compared("gradients", &words, watch)? {
                row["budget"] = json!(size.rollouts);
                rows.push(row);
            }
        }
    }
    Ok(rows)
}

fn table(rows: &[Value]) -> anyhow::Result<Grid> {
    let read = |row: &Value| {
        let mut row = row.clone();
        let budget = row.as_object_mut().and_then(|members| members.shift_remove("budget"));
        Ok((budget.and_then(|budget| budget.as_u64()).unwrap_or(0), serde_json::from_value(row)?))
    };
    let rows = rows.iter().map(read).collect::<anyhow::Result<Vec<(u64, Row)>>>()?;
    let budgets: IndexSet<u64> = rows.iter().map(|(budget, _)| *budget).collect();
    let models: IndexSet<&str> = rows.iter().map(|(_, row)| row.model.as_str()).collect();
    let planners: IndexSet<&str> = rows.iter().map(|(_, row)| row.planner.as_str()).collect();
    let of = |budget: u64, model: &str, planner: &str| -> Vec<&Row> {
        let own = rows.iter().filter(|(spent, row)| *spent == budget && row.model == model && row.planner == planner);
        own.map(|(_, row)| row).collect()
    };
    // What the best plan that any search with the same model found for the same start and goal promises.
    let best = |row: &Row| {
        let same = |other: &Row| (&other.model, &other.goal, other.seed) == (&row.model, &row.goal, row.seed);
        let found = rows.iter().filter(|(_, other)| same(other)).filter_map(|(_, other)| other.predicted);
        found.fold(f64::INFINITY, f64::min)
    };
    let (mut lines, mut verdicts, mut kept) = (Vec::new(), Vec::new(), Vec::new());
    for model in &models {
        let (mut promises, mut costs) = (Vec::new(), Vec::new());
        for (budget, planner) in
            budgets.iter().flat_map(|budget| planners.iter().map(move |planner| (*budget, *planner)))
        {
            let (mine, reference) = (of(budget, model, planner), of(budget, model, REFERENCE));
            if mine.is_empty() {
                continue;
            }
            let own = planner == REFERENCE;
            let (promise, cost) =
                (difference_of(|row| row.predicted, &mine, &reference), difference(&mine, &reference));
            if !own {
                promises.push((format!("{planner} at {budget}"), promise));
                costs.push((format!("{planner} at {budget}"), cost));
            }
            let mean = |value: &dyn Fn(&Row) -> Option<f64>| {
                Interval::over_seeds(mine.iter().filter_map(|row| Some((row.seed, value(row)?))))
            };
            let left = mean(&|row| Some((row.predicted? - best(row)) / (row.start - best(row))));
            let delta = |delta| if own { "reference".to_owned() } else { Interval::millimetres(delta) };
            let seconds = |rows: &[&Row]| median(rows.iter().map(|row| row.seconds).collect());
            let spent =
                |value: fn(&Row) -> usize| mine.iter().map(|row| value(row) as f64).sum::<f64>() / mine.len() as f64;
            lines.push(vec![
                (*model).to_owned(),
                budget.to_string(),
                planner.to_owned(),
                Interval::millimetres(mean(&|row| row.predicted)),
                delta(promise),
                Interval::shares(left),
                Interval::millimetres(mean(&|row| row.achieved)),
                delta(cost),
                format!("{:.0} + {:.0}", spent(|row| row.rollouts), spent(|row| row.gradients)),
                format!("{:.2}", seconds(&mine) / seconds(&reference)),
            ]);
        }
        let said = |what: &str, found| format!("{what} with {model} against {REFERENCE}: {}", verdict(found));
        for planner in planners.iter().filter(|planner| **planner != REFERENCE && !promises.is_empty()) {
            let own = promises.iter().filter(|(label, _)| label.starts_with(&format!("{planner} at ")));
            kept.extend(own.map(|(label, promise)| (format!("{label} with {model}"), lower(*promise))));
        }
        if !promises.is_empty() {
            verdicts.extend([said("predicted", promises), said("achieved", costs)]);
        }
    }
    let header = [
        "model",
        "budget",
        "search",
        "predicted [mm]",
        "Δ cem [mm]",
        "gap left",
        "achieved [mm]",
        "Δ cem [mm]",
        "rollouts + gradients",
        "÷ cem, seconds",
    ];
    let mut notes = vec![
        "mean ± 95 % interval over seeds, each the mean over two goals, each planned with the tool that made it; one fit a model; Δ cem: \
         paired by goal and seed, negative is better. Every budget is planned anew with sizes that spend it, a gradient taking three \
         rollouts of it"
            .to_owned(),
        "gap left: predicted cost above that of the best plan that any search at any budget found with this model for the start and goal, \
         over the same of not acting"
            .to_owned(),
    ];
    notes.extend(verdicts);
    notes.push(adjudge(&format!("a lower predicted cost than {REFERENCE} at every budget"), kept));
    Ok(Grid { title: "When exact gradients pay".into(), header: header.map(String::from).to_vec(), rows: lines, notes })
}
