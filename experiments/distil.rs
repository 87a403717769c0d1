//! Claim: a pair network trained on what a known law moves is read back as a formula whose forces are within 1 % of that law's on
//! held-out pairs; on Rapier's dough the formula that a network is read as predicts and plans better than a model in which nothing
//! moves.
//!
//! Command: `cargo run --release --bin experiments -- distil`, about ten minutes. Table: `paper/tables/distil.tex`.
use crate::adjudge::{adjudge, lower};
use crate::claim::{Experiment, Rows, Size, median, number, verdict};
use crate::collisions::{REACH, episodes, error, laws, model, said};
use anyhow::{Context, ensure};
use pliant::compare::{CompareSpec, ContenderSpec, RUNS, commit, compare};
use pliant::config;
use pliant::model::law::formula::FormulaSpec;
use pliant::model::law::{LearnedPairSpec, Message};
use pliant::table::{Grid, Interval};
use pliant::train::FitSpec;
use pliant::train::distil::{Candidate, DistilSpec, FRONT, Heard, Reading, encounters};
use pliant::watch::Watch;
use serde_json::{Value, json};
use std::path::Path;
use std::time::Instant;

pub(crate) const CLAIM: Experiment = Experiment {
    name: "distil",
    claim: "a pair network read back as a formula is within 1 % of the known law that made its data; so read, dough is planned with better than by `still`",
    duration: "about 10 minutes",
    rows: Rows::Measured(measure),
    table,
};

/// Force error on held-out pairs that counts as having found the law.
const FOUND: f64 = 0.01;
/// How the network is trained where the law is known: no noise, short control steps, many of them.
const KNOWN: [&str; 8] = [
    "train.pair.batch=16",
    "train.pair.noise=0.0",
    "train.pair.turn=3.0",
    "train.pair.horizon=1",
    "train.pair.motion=0.0",
    "train.pair.rate=3e-2",
    "train.pair.warm_up=50",
    "train.pair.last_rate=1e-3",
];
/// Weight of the messages' mean size in that training \[s²/m\].
const SPARSITY: f64 = 1e-5;

fn measure(size: Size, _: &Path, watch: &Watch) -> anyhow::Result<Vec<Value>> {
    let mut rows = Vec::new();
    let seeds = if size == Size::Paper { 3 } else { 1 };
    for (name, law) in laws() {
        for seed in 0..seeds {
            rows.extend(known(name, &law, seed, size, watch)?);
        }
    }
    rows.extend(dough(size, watch)?);
    Ok(rows)
}

/// The stages of the model `distilled`, trained for so many steps and searched for so many generations.
fn stages(steps: usize, generations: usize, seed: u64, sparsity: f64) -> anyhow::Result<(FitSpec, DistilSpec)> {
    let mut words = KNOWN.map(str::to_owned).to_vec();
    words.push(format!("train.pair.steps={steps}"));
    words.push(format!("train.pair.validate_every={}", steps.div_ceil(20)));
    words.push(format!("train.pair.seed={seed}"));
    words.push(format!("train.pair.sparsity={sparsity:?}"));
    words.push(format!("train.distil.generations={generations}"));
    words.push(format!("train.distil.seed={seed}"));
    let spec = config::load::<ContenderSpec>("configs/model/distilled.toml".as_ref(), &words)?.spec;
    let Some(FitSpec::Distil(distil)) = spec.train.get("distil") else { anyhow::bail!("distil reads no messages") };
    Ok((spec.train["pair"].clone(), distil.clone()))
}

/// The network, the formula that it is read as, and the formula that the law's own forces are read as, on data that the law made.
fn known(name: &str, law: &Value, seed: u64, size: Size, watch: &Watch) -> anyhow::Result<Vec<Value>> {
    let (steps, generations, counts) = match size {
        Size::Paper => (8000, 40, [60, 15]),
        Size::Smoke => (20, 3, [4, 2]),
    };
    let truth: FormulaSpec = serde_json::from_value({
        let mut law = law.clone();
        law.as_object_mut().context("a law is a table")?.shift_remove("kind");
        law
    })?;
    let split = episodes(law, counts, seed)?;
    let pair = json!({ "kind": "learned_pair", "width": 32, "edges": ["particle"], "radius": REACH, "skin": 0.006,
        "strength": 10.0, "speed": 0.1, "seed": seed });
    let learned = |sparsity: f64| -> anyhow::Result<(Heard, f64)> {
        let (train, distil) = stages(steps, generations, seed, sparsity)?;
        let mark = config::fingerprint(&json!([law, pair, train, counts]));
        let began = Instant::now();
        let folder = Path::new(RUNS).join("distil").join(mark.to_string());
        let network = train.build()?.fit(&model(&pair)?, &split, &folder, watch)?.build()?;
        Ok((distil.build()?.listen(&*network, &split)?, began.elapsed().as_secs_f64()))
    };
    let (heard, trained) = learned(SPARSITY)?;
    let distiller = stages(steps, generations, seed, SPARSITY)?.1.build()?;
    let so = |heard: &[Message]| said(&truth, heard);
    let exact = Heard { fit: so(&heard.fit)?, validation: so(&heard.validation)?, held_out: so(&heard.held_out)? };
    let mut spec = pair.clone();
    spec.as_object_mut().context("a law is a table")?.shift_remove("kind");
    let encounter = &encounters(&serde_json::from_value::<LearnedPairSpec>(spec)?)?[0];
    let share = |heard: &[Message]| {
        let sum = |of: fn(&Message) -> f64| heard.iter().map(|m| of(m).powi(2)).sum::<f64>();
        (sum(|m| m.tangential) / (sum(|m| m.tangential) + sum(|m| m.normal))).sqrt()
    };
    let row = |what: &str, said: &[Message], seconds: f64, reading: Option<&Reading>| {
        let chosen: Vec<&Candidate> = reading.iter().flat_map(|r| &r.front).filter(|c| c.chosen).collect();
        json!({ "part": "known", "data": name, "model": what, "seed": seed, "seconds": seconds,
            "error": error(said, &exact.held_out), "tangential": share(said), "complexity": chosen.iter().map(|c| c.complexity).sum::<usize>(),
            "chosen": chosen })
    };
    let mut rows = vec![row("network", &heard.held_out, trained, None)];
    if seed == 0 {
        let (free, seconds) = learned(0.0)?;
        rows.push(row("network without penalty", &free.held_out, seconds, None));
    }
    for (what, of) in [("formula of the network", &heard), ("formula of the law", &exact)] {
        let began = Instant::now();
        let reading = distiller.read(of, encounter, watch)?;
        let found = match &reading.law {
            Some(law) => said(law, &heard.held_out)?,
            None => heard.held_out.iter().map(|m| Message { normal: 0.0, tangential: 0.0, ..*m }).collect(),
        };
        rows.push(row(what, &found, began.elapsed().as_secs_f64(), Some(&reading)));
    }
    Ok(rows)
}

/// How the models of `configs/compare/distil.toml` predict and plan, and which formulas were found.
fn dough(size: Size, watch: &Watch) -> anyhow::Result<Vec<Value>> {
    let mut words = vec!["planner=[cem]"];
    if size == Size::Smoke {
        words.extend(["dataset=smoke", "seeds=[0]", "goal=[pressed]", "budget.rollouts=4"]);
        words.extend(["model.analytic.train.identify.evaluations=12", "model.pair.train.pair.steps=4"]);
        words.extend(["model.distilled.train.pair.steps=4", "model.distilled.train.distil.generations=3"]);
    }
    let words: Vec<String> = words.into_iter().map(str::to_owned).collect();
    let loaded = config::load::<CompareSpec>("configs/compare/distil.toml".as_ref(), &words)?;
    let comparison = compare(&loaded, &commit(), watch)?;
    let mut rows = Vec::new();
    for p in &comparison.predictions {
        rows.push(json!({ "part": "prediction", "model": p.model, "one_step": p.held_out.one_step,
            "rollout": p.held_out.rollout, "not_finite": p.held_out.not_finite }));
    }
    for row in comparison.rows() {
        rows.push(json!({ "part": "plan", "model": row.model, "goal": row.goal, "seed": row.seed,
            "achieved": row.achieved, "start": row.start, "not_finite": row.not_finite }));
    }
    let folder = comparison.stages.iter().find(|(model, stage, _)| model == "distilled" && stage == "distil");
    let (.., folder) = folder.context("the comparison distils nothing")?;
    for line in crate::claim::read(&folder.join(FRONT))?.lines() {
        let mut row: Value = serde_json::from_str(line)?;
        row["part"] = json!("front");
        rows.push(row);
    }
    Ok(rows)
}

fn table(rows: &[Value]) -> anyhow::Result<Grid> {
    ensure!(!rows.is_empty(), "there are no rows");
    let of = |part: &str| rows.iter().filter(|row| row["part"] == part).collect::<Vec<_>>();
    let text = |row: &Value, key: &str| row[key].as_str().unwrap_or("–").to_owned();
    let mut lines: Vec<Vec<String>> = Vec::new();
    let mut notes: Vec<String> = Vec::new();
    for row in of("known") {
        let (data, model) = (text(row, "data"), text(row, "model"));
        if lines.iter().any(|line| line[..2] == [data.clone(), model.clone()]) {
            continue;
        }
        let same: Vec<&Value> =
            of("known").into_iter().filter(|r| r["data"] == row["data"] && r["model"] == row["model"]).collect();
        let all = |key: &str| same.iter().map(|row| number(row, key)).collect::<Vec<f64>>();
        let worst = all("error").into_iter().fold(f64::NAN, f64::max);
        let claim = if model == "formula of the network" { verdict(worst <= FOUND) } else { "–" };
        if !model.starts_with("network") {
            notes.push(format!("{data}, {model}, first start: {}", formulas(row["chosen"].as_array())));
        }
        let percent = |x: f64| format!("{:.3}", 100.0 * x);
        let complexity =
            if model.starts_with("network") { "–".to_owned() } else { format!("{:.0}", median(all("complexity"))) };
        let dashes = ["–"; 3].map(str::to_owned);
        let (error, tangential) = (percent(median(all("error"))), percent(median(all("tangential"))));
        lines.push([data, model, error, percent(worst), tangential, complexity].into());
        lines.last_mut().expect("a line").extend(dashes.into_iter().chain([claim.to_owned()]));
    }
    let plans = of("plan");
    let mut names: Vec<&Value> = Vec::new();
    plans.iter().for_each(|row| {
        if !names.contains(&&row["model"]) {
            names.push(&row["model"])
        }
    });
    let achieved = |name: &Value| {
        let own = plans.iter().filter(|row| row["model"] == *name);
        Interval::over_seeds(own.map(|row| (row["seed"].as_u64().unwrap_or(0), number(row, "achieved"))))
    };
    let nearer = {
        let of = |name: &'static str| plans.iter().filter(move |row| row["model"] == name);
        lower(Interval::over_seeds(of("distilled").filter_map(|row| {
            let other = of("still").find(|other| other["goal"] == row["goal"] && other["seed"] == row["seed"])?;
            Some((row["seed"].as_u64()?, number(row, "achieved") - number(other, "achieved")))
        })))
    };
    let front: Vec<Value> = of("front").into_iter().filter(|row| row["chosen"] == true).cloned().collect();
    for name in names {
        let predicted = of("prediction").into_iter().find(|row| row["model"] == *name);
        let millimetres = |key: &str| {
            let value = predicted.map_or(f64::NAN, |row| number(row, key));
            if value.is_finite() { format!("{:.3}", 1e3 * value) } else { "–".to_owned() }
        };
        let distilled = name == "distilled";
        let below = |key: &str| {
            let of =
                |name: &str| of("prediction").into_iter().find(|row| row["model"] == name).map(|row| number(row, key));
            of("distilled") < of("still")
        };
        let complexity: u64 = front.iter().filter_map(|row| row["complexity"].as_u64()).sum();
        let off = front.iter().map(|row| number(row, "held_out")).fold(f64::NAN, f64::max);
        lines.push(vec![
            "dough".to_owned(),
            name.as_str().unwrap_or("–").to_owned(),
            "–".to_owned(),
            if distilled { format!("{:.3}", 100.0 * off) } else { "–".to_owned() },
            "–".to_owned(),
            if distilled { complexity.to_string() } else { "–".to_owned() },
            millimetres("one_step"),
            millimetres("rollout"),
            Interval::millimetres(achieved(name)),
            match nearer {
                _ if !distilled => "–",
                None => "not shown",
                Some(nearer) => verdict(nearer && below("one_step") && below("rollout")),
            }
            .to_owned(),
        ]);
    }
    notes.push(format!("dough, distilled: {}", formulas(Some(&front))));
    notes.insert(
        0,
        "force error: root mean square over held-out pairs of the forces' difference, over that of the true forces"
            .into(),
    );
    notes.insert(
        1,
        "medians and worst over starts, of the network without penalty the first; on dough, of the formula against the network that it was read from".into(),
    );
    notes.insert(
        2,
        format!("claim: the formula of the network within {:.0} % of the law from every start; on dough it predicts and plans better than still", 100.0 * FOUND),
    );
    // The last column is the claim, a dash where none is made.
    let claims = lines.iter().filter(|line| line[line.len() - 1] != "–");
    let told = |said: &str| (said != "not shown").then(|| said == verdict(true));
    let claims = claims.map(|line| (format!("{}, {}", line[0], line[1]), told(&line[line.len() - 1])));
    notes.push(adjudge("networks read back as laws, and planned with on dough", claims));
    let header = [
        "data",
        "model",
        "force error [%]",
        "at most [%]",
        "tangential [%]",
        "complexity",
        "one step [mm]",
        "rollout [mm]",
        "achieved [mm]",
        "claim",
    ];
    Ok(Grid {
        title: "Distillation: the network read as a formula, on data of known laws and on Rapier's dough".into(),
        header: header.map(String::from).to_vec(),
        rows: lines,
        notes,
    })
}

/// `normal_force = …; tangential_force = …` with the constants in place of their names.
fn formulas(chosen: Option<&Vec<Value>>) -> String {
    let one = |row: &Value| {
        let mut text = row["formula"].as_str().unwrap_or("–").to_owned();
        // The last first: c1 is in c10.
        for (name, value) in row["constants"].as_object().into_iter().flatten().rev() {
            let value = value.as_f64().unwrap_or(f64::NAN);
            let plain = (1e-2..1e5).contains(&value);
            text = text.replace(name.as_str(), &if plain { format!("{value:.4}") } else { format!("{value:.3e}") });
        }
        format!("{} = {text}", row["force"].as_str().unwrap_or("–"))
    };
    chosen.into_iter().flatten().map(one).collect::<Vec<_>>().join("; ")
}
