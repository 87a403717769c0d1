//! Claims: a model that is right, left alone, needs no observation; every other does better when it observes between actions, and
//! all do once somebody moves the dough; planning anew only where a prediction has failed costs fewer plans.
//!
//! Command: `cargo run --release --bin experiments -- disturbances`, about ten minutes. Table: `paper/tables/disturbances.tex`.
use crate::adjudge::{NO_WORSE, WORLD, adjudge, lower};
use crate::claim::{Experiment, Rows, difference, difference_of, paired, trials};
use indexmap::IndexSet;
use pliant::compare::Row;
use pliant::table::{Grid, Interval, TrialRow, verdict};
use serde_json::Value;

pub(crate) const CLAIM: Experiment = Experiment {
    name: "disturbances",
    claim: "observing between actions helps wrong models, and every model once the dough is disturbed",
    duration: "about 10 minutes",
    rows: Rows::Sweep { config: "configs/sweep/disturbances.toml", smoke: &["model=[still, analytic_wrong]"] },
    table,
};

/// A way of control: its name, and what its changes hold.
const WAYS: [(&str, &str); 3] = [("open", "control=open"), ("closed", ""), ("triggered", "triggered")];

/// Whether a trial's changes are those of a way of control in a world disturbed or not.
fn is(change: &str, way: &str, disturbed: &str) -> bool {
    let own = WAYS.iter().rev().find(|(_, mark)| !mark.is_empty() && change.contains(mark));
    own.map_or("closed", |(name, _)| name) == way && change.contains("disturbance=") == (disturbed == "disturbed")
}

fn table(rows: &[Value]) -> anyhow::Result<Grid> {
    let trials = trials(rows)?;
    let models: IndexSet<&str> = trials.iter().map(|trial| trial.row.model.as_str()).collect();
    let header = ["world", "model", "open [mm]", "closed [mm]", "triggered [mm]"].into_iter();
    let header = header.chain(["closed − open [mm]", "triggered − closed [mm]", "plans closed", "plans triggered"]);
    let (mut lines, mut seen, mut kept, mut right, mut fewer) = (vec![], vec![], vec![], vec![], vec![]);
    for world in ["left alone", "disturbed"] {
        for model in &models {
            let of = |way: &str| rows_of(&trials, model, way, world);
            let [open, closed, triggered] = WAYS.map(|(way, _)| of(way));
            let achieved = |rows: &[&Row]| {
                let found = rows.iter().filter_map(|row| Some((row.seed, row.achieved?)));
                Interval::millimetres(Interval::over_seeds(found))
            };
            let (observing, keeping) = (difference(&closed, &open), difference(&triggered, &closed));
            let label = format!("{model} {world}");
            if *model == WORLD && world == "left alone" {
                let unobserved = paired(|row| row.achieved, NO_WORSE, &open, &closed);
                right.push((label.clone(), lower(unobserved)));
            } else {
                seen.push((label.clone(), lower(observing)));
            }
            let counted = difference_of(|row| Some(made(row)), &triggered, &closed);
            fewer.push((label.clone(), lower(counted)));
            kept.push((label, keeping));
            let plans = |rows: &[&Row]| {
                let all = rows.iter().map(|row| made(row)).sum::<f64>();
                if rows.is_empty() { "–".to_owned() } else { format!("{:.1}", all / rows.len() as f64) }
            };
            lines.push(vec![
                world.to_owned(),
                (*model).to_owned(),
                achieved(&open),
                achieved(&closed),
                achieved(&triggered),
                Interval::millimetres(observing),
                Interval::millimetres(keeping),
                plans(&closed),
                plans(&triggered),
            ]);
        }
    }
    let over = |read: &dyn Fn(&Row) -> Option<f64>| {
        let found = trials.iter().filter_map(|trial| Some((trial.row.seed, read(&trial.row)?)));
        Interval::millimetres(Interval::over_seeds(found))
    };
    let (start, floor) = (over(&|row| Some(row.start)), over(&|row| *row.floors.get("chamfer")?));
    Ok(Grid {
        title: "Observing, left alone and disturbed".into(),
        header: header.map(String::from).collect(),
        rows: lines,
        notes: vec![
            "achieved cost, mean ± 95 % interval over seeds; differences paired by goal and seed, negative is better".into(),
            "triggered: a plan of two actions with one tool is kept while what is observed lies within 6 mm (Chamfer) of what \
             was predicted; closed and open: one action a plan, any tool. A search of two actions has twice the rollouts, so that \
             both try equally many candidates"
                .into(),
            format!("before the first action the cost is {start} mm; of two samplings of the goal itself it is {floor} mm"),
            adjudge("a wrong model, and every model disturbed, achieves less cost in closed than in open loop", seen),
            adjudge(&format!("a right model left alone achieves below {NO_WORSE} × the cost of closed loop in open loop"), right),
            adjudge("fewer plans triggered than in closed loop", fewer),
            format!("triggered against closed: {}", verdict(kept)),
        ],
    })
}

/// Plans that an attempt took.
fn made(row: &Row) -> f64 {
    row.plans.unwrap_or(row.tools.len()) as f64
}

fn rows_of<'a>(trials: &'a [TrialRow], model: &str, way: &str, world: &str) -> Vec<&'a Row> {
    let own = |trial: &&TrialRow| trial.row.model == model && is(&trial.change, way, world);
    trials.iter().filter(own).map(|trial| &trial.row).collect()
}
