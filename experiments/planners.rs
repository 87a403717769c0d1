//! Claim: with an exact gradient, descending plans better than sampling, and both together better than either, for equally many
//! rollouts and for equal time; a policy's plans take less time and cost at most a tenth more.
//!
//! Command: `cargo run --release --bin experiments -- planners`, about twenty minutes. Table: `paper/tables/planners.tex`.
use crate::adjudge::{NO_WORSE, NOBODY, WORLD, adjudge, at_most, lower};
use crate::claim::{Experiment, Rows, SMALL_FITS, Size, compared, difference, median, paired};
use indexmap::IndexSet;
use pliant::compare::Row;
use pliant::table::{Grid, Interval, verdict};
use pliant::watch::Watch;
use serde_json::{Value, json};
use std::path::Path;

pub(crate) const CLAIM: Experiment = Experiment {
    name: "planners",
    claim: "gradients plan better than samples, both together better than either; a policy costs a tenth more at most, in less time",
    duration: "about 20 minutes",
    rows: Rows::Measured(measure),
    table,
};

/// What each search may spend, and what changes for it; the simulator plans with one planner, for its price.
const BUDGETS: [(&str, &[&str]); 3] = [
    ("40 rollouts", &[]),
    (
        "40 rollouts",
        &[
            "model=[oracle]",
            "~planner.random",
            "~planner.grid",
            "~planner.mppi",
            "~planner.covo",
            "~planner.descent",
            "~planner.lbfgs",
            "~planner.refine",
            "~planner.policy",
            "~planner.policy_refine",
        ],
    ),
    (
        "0.2 s",
        &[
            "budget={rollouts: 1000000, gradient_price: 3, seconds: 0.2}",
            "planner.random.samples=100000",
            "planner.grid.samples=100000",
            "planner.cem.rounds=10000",
            "planner.cem.patience=10000",
            "planner.mppi.rounds=10000",
            "planner.covo.mppi.rounds=10000",
            "planner.descent.steps=200",
            "planner.lbfgs.steps=200",
            "planner.refine.descent.steps=200",
            "planner.policy_refine.cem.rounds=10000",
            "planner.policy_refine.cem.patience=10000",
        ],
    ),
];
const SMOKE: [&str; 5] = [
    "dataset=smoke",
    "seeds=[0]",
    "goal=[pressed]",
    "budget={rollouts: 4, gradient_price: 3}",
    "model=[still, analytic]",
];
const SMALL: &str = "+policy={samples: 12, network: {steps: 3, width: 8}}";
/// What is claimed of the achieved cost, and who achieves less than whom: gradients alone, samples, and samples before gradients.
const CLAIMS: [(&str, &[[&str; 2]]); 2] = [
    ("gradients achieve less cost than samples", &[["descent", REFERENCE], ["lbfgs", REFERENCE]]),
    ("both achieve less cost than either", &[["refine", REFERENCE], ["refine", "descent"]]),
];
const POLICY: &str = "policy";
/// What every planner is compared with.
const REFERENCE: &str = "cem";

fn measure(size: Size, _: &Path, watch: &Watch) -> anyhow::Result<Vec<Value>> {
    let small = [&SMALL_FITS[..1], &[SMALL]].concat();
    let (budgets, smoke) =
        if size == Size::Smoke { (&BUDGETS[..1], [&SMOKE[..], &small].concat()) } else { (&BUDGETS[..], Vec::new()) };
    let mut rows = Vec::new();
    for (name, words) in budgets {
        let words: Vec<String> = words.iter().chain(&smoke).map(|word| (*word).to_owned()).collect();
        for mut row in compared("planners", &words, watch)? {
            row["budget"] = json!(name);
            rows.push(row);
        }
    }
    Ok(rows)
}

fn table(rows: &[Value]) -> anyhow::Result<Grid> {
    let read = |row: &Value| {
        let budget = row["budget"].as_str().unwrap_or("–").to_owned();
        let mut row = row.clone();
        row.as_object_mut().map(|members| members.remove("budget"));
        Ok((budget, serde_json::from_value(row)?))
    };
    let rows = rows.iter().map(read).collect::<anyhow::Result<Vec<(String, Row)>>>()?;
    let budgets: IndexSet<&str> = rows.iter().map(|(budget, _)| budget.as_str()).collect();
    let models: IndexSet<&str> = rows.iter().map(|(_, row)| row.model.as_str()).collect();
    let planners: IndexSet<&str> = rows.iter().map(|(_, row)| row.planner.as_str()).collect();
    let of = |budget: &str, model: &str, planner: &str| -> Vec<&Row> {
        let own = rows.iter().filter(|(spent, row)| spent == budget && row.model == model && row.planner == planner);
        own.map(|(_, row)| row).collect()
    };
    let (mut lines, mut verdicts) = (Vec::new(), Vec::new());
    let mut claims = CLAIMS.map(|_| Vec::new());
    let mut quick = Vec::new();
    for budget in &budgets {
        for model in &models {
            let reference = of(budget, model, REFERENCE);
            let mut said = Vec::new();
            for planner in &planners {
                let mine = of(budget, model, planner);
                if mine.is_empty() {
                    continue;
                }
                let planned: Vec<&Row> = mine.iter().copied().filter(|row| row.achieved.is_some()).collect();
                let mean = |value: fn(&Row) -> usize| {
                    planned.iter().map(|row| value(row) as f64).sum::<f64>() / planned.len().max(1) as f64
                };
                let time = median(planned.iter().map(|row| row.seconds).collect());
                let delta = (*planner != REFERENCE).then(|| difference(&planned, &reference)).flatten();
                let told = |told: String| if planned.is_empty() { "–".to_owned() } else { told };
                let achieved = Interval::over_seeds(planned.iter().filter_map(|row| Some((row.seed, row.achieved?))));
                let promised = planned.iter().filter_map(|row| Some((row.seed, row.predicted? - row.achieved?)));
                lines.push(vec![
                    (*budget).to_owned(),
                    (*model).to_owned(),
                    (*planner).to_owned(),
                    Interval::millimetres(achieved),
                    if *planner == REFERENCE { "reference".to_owned() } else { Interval::millimetres(delta) },
                    Interval::millimetres(Interval::over_seeds(promised)),
                    told(format!("{:.0} + {:.0}", mean(|row| row.rollouts), mean(|row| row.gradients))),
                    told(format!("{time:.3}")),
                    told(format!("{:.1}", time.recip())),
                ]);
                said.push(((*planner).to_owned(), delta));
            }
            if ![NOBODY, WORLD].contains(model) {
                let planned = |planner: &str| -> Vec<&Row> {
                    of(budget, model, planner).into_iter().filter(|row| row.achieved.is_some()).collect()
                };
                let label = |mine: &str, other: &str| format!("{mine} against {other} with {model} and {budget}");
                for ((_, pairs), claim) in CLAIMS.iter().zip(&mut claims) {
                    claim.extend(
                        pairs.iter().map(|[mine, other]| {
                            (label(mine, other), lower(difference(&planned(mine), &planned(other))))
                        }),
                    );
                }
                let (mine, other) = (planned(POLICY), planned(REFERENCE));
                let time = |rows: &[&Row]| median(rows.iter().map(|row| row.seconds).collect());
                quick.push((
                    format!("cost, {}", label(POLICY, REFERENCE)),
                    lower(paired(|row| row.achieved, NO_WORSE, &mine, &other)),
                ));
                quick
                    .push((format!("seconds, {}", label(POLICY, REFERENCE)), at_most(time(&mine) / time(&other), 1.0)));
            }
            let said = verdict(said);
            if !said.is_empty() {
                verdicts.push(format!("achieved with {model} and {budget} a tool, against {REFERENCE}: {said}"));
            }
        }
    }
    let header = [
        "budget a tool",
        "model",
        "planner",
        "achieved [mm]",
        "Δ cem [mm]",
        "predicted − achieved [mm]",
        "rollouts + gradients",
        "seconds a plan",
        "plans a second",
    ];
    let mut notes = vec![
        "achieved: mean ± 95 % interval over seeds, each the mean over goals, one fit a model; Δ cem: paired by goal and seed, negative \
         is better; a plan chooses among three tools, each with a budget of its own, of which a gradient takes three rollouts"
            .to_owned(),
        "a dash: the planner needs a gradient, or a policy, that the model cannot give; the simulator plans with one planner, for its \
         price"
            .to_owned(),
    ];
    notes.extend(verdicts);
    notes.extend(CLAIMS.iter().zip(claims).map(|((what, _), lines)| adjudge(what, lines)));
    notes.push(adjudge(&format!("a policy's plans cost below {NO_WORSE} × those of {REFERENCE}, in less time"), quick));
    Ok(Grid {
        title: "Every planner with written, learned and hybrid models, and with one in which nothing moves (still)"
            .into(),
        header: header.map(String::from).to_vec(),
        rows: lines,
        notes,
    })
}
