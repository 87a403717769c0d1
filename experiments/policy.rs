//! Claim: what a policy learned from a model's own rollouts proposes is planned at least twenty times faster than CEM plans with the
//! same model, and achieves a cost that is at most a tenth higher.
//!
//! Command: `cargo run --release --bin experiments -- policy`, about ten minutes. Table: `paper/tables/policy.tex`.
use crate::adjudge::{NO_WORSE, adjudge, at_most, lower};
use crate::claim::{Experiment, Rows, Size, compared, difference, median, paired};
use anyhow::ensure;
use indexmap::IndexSet;
use pliant::compare::Row;
use pliant::table::{Grid, Interval};
use pliant::watch::Watch;
use serde_json::Value;
use std::path::Path;

pub(crate) const CLAIM: Experiment = Experiment {
    name: "policy",
    claim: "a policy learned from a model's own rollouts plans at least 20 times faster than CEM on that model, at most 10 % worse",
    duration: "about 10 minutes",
    rows: Rows::Measured(measure),
    table,
};

/// How many times faster than the reference a policy must be.
const FASTER: f64 = 20.0;
/// The planner that the others are compared with.
const REFERENCE: &str = "cem";

/// The simulator plans apart from the others, with a budget that its price allows.
const ORACLE: [&str; 2] = ["model=[oracle]", "budget.rollouts=14"];
/// What makes both tiny, and the fits.
const SMOKE: [&str; 4] = ["dataset=smoke", "seeds=[0]", "goal=[pressed]", "budget.rollouts=4"];
const SMALL: [&str; 3] = [
    "model.analytic.train.identify.evaluations=12",
    "model.learned.train.network.steps=4",
    "+policy={samples: 12, network: {steps: 3, width: 8}}",
];

fn measure(size: Size, _: &Path, watch: &Watch) -> anyhow::Result<Vec<Value>> {
    let (smoke, small) = if size == Size::Smoke { (&SMOKE[..], &SMALL[..]) } else { (&[][..], &[][..]) };
    let mut rows = Vec::new();
    for words in [[smoke, small].concat(), [&ORACLE[..], smoke].concat()] {
        let words: Vec<String> = words.into_iter().map(str::to_owned).collect();
        rows.extend(compared("policy", &words, watch)?);
    }
    Ok(rows)
}

/// Attempts of one planner with one model.
fn of<'a>(rows: &'a [Row], planner: &str, model: &str) -> Vec<&'a Row> {
    rows.iter().filter(|row| row.planner == planner && row.model == model).collect()
}

fn achieved(rows: &[&Row]) -> Option<Interval> {
    Interval::over_seeds(rows.iter().filter_map(|row| Some((row.seed, row.achieved?))))
}

fn seconds(rows: &[&Row]) -> f64 {
    median(rows.iter().filter(|row| row.achieved.is_some()).map(|row| row.seconds).collect())
}

/// Mean achieved cost over that of the reference.
fn worse(mine: &[&Row], reference: &[&Row]) -> Option<f64> {
    Some(achieved(mine)?.mean / achieved(reference)?.mean)
}

fn table(rows: &[Value]) -> anyhow::Result<Grid> {
    let rows: Vec<Row> = rows.iter().map(|row| serde_json::from_value(row.clone())).collect::<Result<_, _>>()?;
    ensure!(!rows.is_empty(), "there are no rows");
    let distinct = |read: fn(&Row) -> &str| rows.iter().map(read).collect::<IndexSet<&str>>();
    let (models, planners, goals) = (distinct(|r| &r.model), distinct(|r| &r.planner), distinct(|r| &r.goal));
    let (mut lines, mut verdicts, mut claims) = (Vec::new(), Vec::new(), Vec::new());
    for (model, planner) in models.iter().flat_map(|model| planners.iter().map(move |planner| (*model, *planner))) {
        let (mine, reference) = (of(&rows, planner, model), of(&rows, REFERENCE, model));
        let here = |rows: &[&'_ Row], goal: &str| -> Vec<Row> {
            rows.iter().filter(|row| row.goal == goal).map(|row| (*row).clone()).collect()
        };
        let own = planner == REFERENCE;
        let ratio = |ratio: Option<f64>| ratio.map_or("–".to_owned(), |ratio| format!("{ratio:.2}"));
        let (cost, speed) = (worse(&mine, &reference), seconds(&reference) / seconds(&mine));
        let planned = mine.iter().filter(|row| row.achieved.is_some()).count();
        let mut cells = vec![model.to_owned(), planner.to_owned(), format!("{planned}/{}", mine.len())];
        cells.push(Interval::millimetres(achieved(&mine)));
        cells.push(if own { "reference".to_owned() } else { Interval::millimetres(difference(&mine, &reference)) });
        cells.push(ratio(cost));
        cells.extend(goals.iter().map(|goal| {
            let (mine, reference) = (here(&mine, goal), here(&reference, goal));
            ratio(worse(&mine.iter().collect::<Vec<_>>(), &reference.iter().collect::<Vec<_>>()))
        }));
        let mean = mine.iter().map(|row| row.rollouts as f64).sum::<f64>() / mine.len() as f64;
        cells.push(format!("{mean:.0}"));
        let time = seconds(&mine);
        cells.push(if time.is_finite() { format!("{time:.3}") } else { "–".to_owned() });
        cells.push(ratio((!own).then_some(speed).filter(|speed| speed.is_finite())));
        lines.push(cells);
        if let Some(cost) = cost.filter(|_| !own && !["oracle", "still"].contains(&model)) {
            let percent = 100.0 * (cost - 1.0);
            let label = format!("{model}, {planner}");
            verdicts.push(format!("{label} {speed:.0} × as fast, {percent:+.0} % cost"));
            claims.push((format!("{label}: speed"), at_most(FASTER, speed)));
            claims.push((format!("{label}: cost"), lower(paired(|row| row.achieved, NO_WORSE, &mine, &reference))));
        }
    }
    let mut header = ["model", "planner", "planned", "achieved [mm]", "Δ cem [mm]", "÷ cem"].map(String::from).to_vec();
    header.extend(goals.iter().map(|goal| format!("÷ cem, {goal}")));
    header.extend(["rollouts", "seconds a plan", "× as fast"].map(String::from));
    Ok(Grid {
        title: "Policies learned from a model's own rollouts".into(),
        header,
        rows: lines,
        notes: vec![
            "achieved: mean ± 95 % interval over seeds, each the mean over goals, one fit a model and policy; Δ cem: paired by goal and \
             seed; ÷ cem: mean achieved cost over that of CEM on the same model; seconds: median, choosing among all tools"
                .into(),
            "a policy never learns from the simulator (oracle), nor from a model in which nothing moves (still): a dash; the simulator \
             plans with fewer rollouts than the models, for their price"
                .into(),
            format!("speed and mean cost beside {REFERENCE}: {}", verdicts.join("; ")),
            adjudge(&format!("{FASTER} × as fast at a cost below {NO_WORSE} ×, paired by goal and seed"), claims),
        ],
    })
}
