//! Claim: in a world of another material, a model of dough plans better after twelve short interactions there than as it was fitted, and
//! gains more by them than in dough itself, where they are only more of the same.
//!
//! Command: `cargo run --release --bin experiments -- materials`, about fifteen minutes. Table: `paper/tables/materials.tex`.
use crate::adjudge::{adjudge, lower};
use crate::claim::{Experiment, Rows, changed, difference, trials};
use indexmap::IndexSet;
use pliant::compare::Row;
use pliant::table::{Grid, Interval, TrialRow, verdict};
use serde_json::Value;

pub(crate) const CLAIM: Experiment = Experiment {
    name: "materials",
    claim: "a model of dough plans better in another material after twelve short interactions there than as it was fitted",
    duration: "about 15 minutes",
    rows: Rows::Sweep {
        config: "configs/sweep/materials.toml",
        smoke: &[
            "interactions=5",
            "model=[still, learned, learned_first_layers]",
            "model.learned.train.network.steps=4",
            "model.learned_first_layers.train.network.steps=4",
            "model.learned_first_layers.adapt.first_layers.steps=3",
        ],
    },
    table,
};

/// Models that adapt, and what each was before.
const ADAPTED: [(&str, &str); 3] =
    [("analytic_adapted", "analytic"), ("learned_first_layers", "learned"), ("learned_adapted", "learned")];
/// The material that all were fitted to.
const OWN: &str = "dough";

/// Error at the end of whole rollouts of `mine` minus that of `reference`, by seed, each having its own held-out episodes \[m\].
fn predicted(mine: &[&Row], reference: &[&Row]) -> Option<Interval> {
    Interval::over_seeds(mine.iter().filter_map(|row| {
        let other = reference.iter().find(|other| other.seed == row.seed)?;
        Some((row.seed, row.rollout? - other.rollout?))
    }))
}

/// How much more `mine` gained on `reference` than theirs did in the material of the fit, paired by goal and seed \[m\].
fn beyond([mine, reference]: [&[&Row]; 2], [own, before]: [&[&Row]; 2]) -> Option<Interval> {
    let gains = |mine: &[&Row], reference: &[&Row], goal: &str, seed: u64| {
        let of = |rows: &[&Row]| rows.iter().find(|row| row.goal == goal && row.seed == seed)?.achieved;
        Some(of(mine)? - of(reference)?)
    };
    Interval::over_seeds(mine.iter().filter_map(|row| {
        let [here, there] = [gains(mine, reference, &row.goal, row.seed), gains(own, before, &row.goal, row.seed)];
        Some((row.seed, here? - there?))
    }))
}

fn table(rows: &[Value]) -> anyhow::Result<Grid> {
    let trials = trials(rows)?;
    let materials: IndexSet<String> = trials.iter().map(|trial| changed(&trial.change, OWN)).collect();
    let models: IndexSet<&str> = trials.iter().map(|trial| trial.row.model.as_str()).collect();
    let of = |material: &str, model: &str| -> Vec<&Row> {
        let own = |trial: &&TrialRow| changed(&trial.change, OWN) == material && trial.row.model == model;
        trials.iter().filter(own).map(|trial| &trial.row).collect()
    };
    let mean = |rows: &[&Row], value: fn(&Row) -> Option<f64>| {
        Interval::millimetres(Interval::over_seeds(rows.iter().filter_map(|row| Some((row.seed, value(row)?)))))
    };
    let (mut lines, mut errors, mut costs, mut further, mut partly) = (vec![], vec![], vec![], vec![], vec![]);
    for material in &materials {
        let oracle = of(material, "oracle");
        for model in &models {
            let mine = of(material, model);
            let before = ADAPTED.iter().find(|(adapted, _)| adapted == model).map(|(_, before)| *before);
            let reference = before.map(|before| of(material, before)).unwrap_or_default();
            let (error, cost) = (predicted(&mine, &reference), difference(&mine, &reference));
            if let Some(before) = before {
                let label = format!("{model} in {material}");
                errors.push((label.clone(), error));
                costs.push((label.clone(), cost));
                if material != OWN {
                    further.push((label, beyond([&mine, &reference], [&of(OWN, model), &of(OWN, before)])));
                }
            }
            let regret = (!["oracle", "still"].contains(model)).then(|| difference(&mine, &oracle)).flatten();
            lines.push(vec![
                material.clone(),
                (*model).to_owned(),
                mean(&mine, |row| row.rollout),
                Interval::millimetres(error),
                mean(&mine, |row| row.achieved),
                Interval::millimetres(cost),
                Interval::millimetres(regret),
                mean(&mine, |row| Some(row.predicted? - row.achieved?)),
            ]);
        }
        let [first, all] = [of(material, "learned_first_layers"), of(material, "learned_adapted")];
        partly.push((material.clone(), difference(&first, &all)));
    }
    let header = [
        "world",
        "model",
        "rollout error [mm]",
        "Δ adapting [mm]",
        "achieved [mm]",
        "Δ adapting [mm]",
        "Δ oracle [mm]",
        "predicted − achieved [mm]",
    ];
    let elsewhere = costs.iter().filter(|(label, _)| !label.ends_with(&format!(" in {OWN}")));
    let elsewhere = elsewhere.map(|(label, cost)| (label.clone(), lower(*cost))).collect::<Vec<_>>();
    let beyond_own = further.iter().map(|(label, gain)| (label.clone(), lower(*gain))).collect::<Vec<_>>();
    let start = Interval::over_seeds(trials.iter().map(|trial| (trial.row.seed, trial.row.start)));
    let start = Interval::millimetres(start);
    Ok(Grid {
        title: "Models of dough in other materials, before and after adapting".into(),
        header: header.map(String::from).to_vec(),
        rows: lines,
        notes: vec![
            "mean ± 95 % interval over seeds, each with another start and twelve other interactions, of which three are held out and judge \
             the rollout error; one fit to dough for all. Δ adapting: minus the same model as it was fitted to dough, paired by seed and \
             goal, negative is better. In dough itself the interactions are only more of the same"
                .into(),
            format!("before the action the cost is {start} mm; the goal is what another action has made of the same start, so that it can be 0"),
            format!("rollout error after adapting against before: {}", verdict(errors)),
            format!("achieved after adapting against before: {}", verdict(costs)),
            adjudge("a lower achieved cost in another material after adapting", elsewhere),
            adjudge("adapting lowers the achieved cost more there than in dough", beyond_own),
            format!("achieved with the first layers adapted against with all: {}", verdict(partly)),
        ],
    })
}
