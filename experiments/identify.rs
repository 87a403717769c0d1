//! Claim: every search recovers the constants that made noise-free data to 2 %, and lowers the error on held-out recordings of
//! Rapier's dough further than random points do at equal evaluations.
//!
//! Command: `cargo run --release --bin experiments -- identify`, about fifteen minutes. Table: `paper/tables/identify.tex`.
use crate::adjudge::adjudge;
use crate::claim::{Experiment, Rows, Size, median, number, verdict};
use crate::recovery::{CONSTANTS, Truth, worst};
use anyhow::{Context, ensure};
use pliant::compare::{ContenderSpec, RUNS, dataset_folder};
use pliant::config;
use pliant::data::{DatasetSpec, simulate};
use pliant::model::{ModelSpec, WorldModel};
use pliant::state::stream;
use pliant::table::Grid;
use pliant::train::search::{at, place};
use pliant::train::{FitSpec, Identification, IdentifySpec, Split, replace, value};
use pliant::watch::Watch;
use rand::Rng;
use serde_json::{Value, json};
use std::path::Path;

pub(crate) const CLAIM: Experiment = Experiment {
    name: "identify",
    claim: "every search recovers known constants to 2 % and lowers the held-out error on Rapier's dough, more than random points do",
    duration: "about 15 minutes",
    rows: Rows::Measured(measure),
    table,
};

/// Stages of `configs/train`, each with another search.
const STAGES: [&str; 6] = [
    "identify",
    "identify_bayesian",
    "identify_gradient",
    "identify_cma_then_gradient",
    "identify_least_squares",
    "identify_random",
];
/// Noise on recorded positions \[m\].
const NOISE: [f64; 6] = [0.0, 1e-5, 3e-5, 1e-4, 3e-4, 1e-3];
/// The search whose error is followed over the noise.
const FOLLOWED: &str = "identify_least_squares";
/// Error of the worst constant that counts as recovered.
const RECOVERED: f64 = 0.02;
/// How far around the config's constants a search starts, as a fraction of the logarithmic width of the bounds.
const AROUND: f64 = 0.25;

fn measure(size: Size, _: &Path, watch: &Watch) -> anyhow::Result<Vec<Value>> {
    let (dataset, seeds, evaluations, windows) = match size {
        Size::Paper => ("quickstart", 3, 160, 8),
        Size::Smoke => ("smoke", 1, 60, 1),
    };
    let spec = config::load::<DatasetSpec>(format!("configs/dataset/{dataset}.toml").as_ref(), &[])?.spec;
    let recorded = Split::of(&simulate(&spec, &dataset_folder(RUNS.as_ref(), &spec), watch)?, 0.1);
    let (_, model) = stage(STAGES[0])?;
    let truth = Truth::new(&*build(&model)?, &recorded);
    let mut rows = Vec::new();
    for name in STAGES {
        let (spec, _) = stage(name)?;
        let spec = IdentifySpec { evaluations, windows, ..spec };
        let known = IdentifySpec {
            constants: CONSTANTS.map(|path| (path.to_owned(), around(&model, path))).into(),
            ..spec.clone()
        };
        let noises = if name == FOLLOWED && size == Size::Paper { &NOISE[..] } else { &NOISE[..1] };
        for (noise, seed) in noises.iter().flat_map(|noise| (0..seeds).map(move |seed| (*noise, seed))) {
            let split = truth.recorded(noise, seed);
            let found = identified(
                &IdentifySpec { seed, ..known.clone() },
                &model,
                &split,
                0.35,
                &json!([noise, size == Size::Paper]),
                watch,
            )?;
            rows.push(row("recovery", name, noise, seed, &found, worst(&found, &model)?));
        }
        for seed in 0..seeds {
            let found = identified(
                &IdentifySpec { seed, ..spec.clone() },
                &model,
                &recorded,
                AROUND,
                &json!([dataset]),
                watch,
            )?;
            rows.push(row("dough", name, 0.0, seed, &found, f64::NAN));
        }
    }
    Ok(rows)
}

/// The identification of one stage, and the model that it fits.
fn stage(name: &str) -> anyhow::Result<(IdentifySpec, Value)> {
    let path = Path::new("configs/model/analytic.toml");
    let spec = config::load::<ContenderSpec>(path, &[format!("train=[{name}]")])?.spec;
    let Some(FitSpec::Identify(identify)) = spec.train.get(name) else { anyhow::bail!("{name} identifies nothing") };
    Ok((identify.clone(), serde_json::to_value(&spec.dynamics)?))
}

fn build(model: &Value) -> anyhow::Result<Box<dyn WorldModel>> {
    serde_json::from_value::<ModelSpec>(model.clone())?.build()
}

/// Bounds a factor of five to either side of a model's constant.
fn around(model: &Value, path: &str) -> [f64; 2] {
    let constant = value(model, path).expect("a constant of the analytical model");
    [constant / 5.0, constant * 5.0]
}

/// What a search finds from a random start at most so far from the model's constants; kept below `runs`, where a stopped one goes
/// on.
fn identified(
    spec: &IdentifySpec,
    model: &Value,
    split: &Split,
    far: f64,
    data: &Value,
    watch: &Watch,
) -> anyhow::Result<Identification> {
    let mut rng = stream(spec.seed, &[u64::from_le_bytes(*b"identify")]);
    let mut shifted = |(path, bounds): (&String, &[f64; 2])| -> anyhow::Result<(String, f64)> {
        let u = place(value(model, path)?, *bounds) + rng.random_range(-far..far);
        Ok((path.clone(), at(u.clamp(0.0, 1.0), *bounds)))
    };
    let start = spec.constants.iter().map(&mut shifted).collect::<anyhow::Result<Vec<_>>>()?;
    let start = replace(model, start.iter().map(|(path, constant)| (path.as_str(), *constant)))?;
    let folder = Path::new(RUNS).join("identify").join(config::fingerprint(&json!([spec, start, data])).to_string());
    let path = folder.join("identify.json");
    if !path.exists() {
        spec.clone().build()?.identify(&start, &build, split, &folder, watch)?;
    }
    let text = std::fs::read_to_string(&path).with_context(|| format!("cannot read {}", path.display()))?;
    serde_json::from_str(&text).with_context(|| format!("{} is damaged; remove it", path.display()))
}

fn row(part: &str, stage: &str, noise: f64, seed: u64, found: &Identification, error: f64) -> Value {
    let held_out = found.held_out.as_ref();
    json!({ "part": part, "stage": stage, "noise": noise, "seed": seed, "error": error,
        "before": held_out.map(|e| e.before), "after": held_out.map(|e| e.after), "still": held_out.map(|e| e.still),
        "evaluations": found.evaluations, "seconds": found.seconds })
}

fn table(rows: &[Value]) -> anyhow::Result<Grid> {
    ensure!(!rows.is_empty(), "there are no rows");
    let mut groups: Vec<(&Value, &Value, &Value)> = Vec::new();
    for row in rows {
        let key = (&row["part"], &row["noise"], &row["stage"]);
        if !groups.contains(&key) {
            groups.push(key);
        }
    }
    groups.sort_by_key(|(part, ..)| part.as_str() == Some("dough"));
    let of = |key: &(&Value, &Value, &Value)| -> Vec<&Value> {
        rows.iter().filter(|row| (&row["part"], &row["noise"], &row["stage"]) == *key).collect()
    };
    let middle = |of: &[&Value], key: &str| median(of.iter().map(|row| number(row, key)).collect());
    let random = rows.iter().filter(|row| row["stage"] == "identify_random" && row["part"] == "dough");
    let random = median(random.map(|row| number(row, "after")).collect());
    let line = |key: &(&Value, &Value, &Value)| {
        let of = of(key);
        let name = key.2.as_str().unwrap_or("–");
        let search = name.strip_prefix("identify_").unwrap_or("cma").replace('_', " ");
        let recovery = key.0 == "recovery";
        let worst = of.iter().map(|row| number(row, "error")).fold(f64::NAN, f64::max);
        let (before, after) = (middle(&of, "before"), middle(&of, "after"));
        let holds = match recovery {
            true => worst <= RECOVERED,
            false => of.iter().all(|row| number(row, "after") < number(row, "before")) && after < random,
        };
        let baseline = search == "random" || (recovery && key.1.as_f64() > Some(0.0));
        let claim = if baseline { "–" } else { verdict(holds) };
        let percent = |x: f64| if x.is_finite() { format!("{:.2}", 100.0 * x) } else { "–".to_owned() };
        let millimetres = |x: f64| if x.is_finite() { format!("{:.3}", 1e3 * x) } else { "–".to_owned() };
        vec![
            key.0.as_str().unwrap_or("–").to_owned(),
            search,
            if recovery { format!("{:.2}", 1e3 * key.1.as_f64().unwrap_or(f64::NAN)) } else { "–".to_owned() },
            percent(middle(&of, "error")),
            percent(worst),
            millimetres(before),
            millimetres(after),
            format!("{:.0}", middle(&of, "evaluations")),
            format!("{:.1}", middle(&of, "seconds")),
            claim.to_owned(),
        ]
    };
    let header = [
        "data",
        "search",
        "noise [mm]",
        "constants off by [%]",
        "at most [%]",
        "before [mm]",
        "after [mm]",
        "evaluations",
        "seconds",
        "claim",
    ];
    let lines: Vec<Vec<String>> = groups.iter().map(line).collect();
    // The last column is the claim, of baselines a dash.
    let claims = lines.iter().filter(|line| line[line.len() - 1] != "–");
    let claims = claims.map(|line| (format!("{}, {}", line[0], line[1]), Some(line[line.len() - 1] == verdict(true))));
    let claims = adjudge("every search recovers, and errs less on dough", claims);
    Ok(Grid {
        title: "Identification: constants recovered from data of the model itself, and held-out errors on Rapier's dough".into(),
        header: header.map(String::from).to_vec(),
        rows: lines,
        notes: vec![
            format!("medians over {} starts; off by: the worst of {} constants", of(&groups[0]).len(), CONSTANTS.len()),
            "noise: standard deviation of every recorded coordinate, and of the differences that velocities are".into(),
            "before, after: root mean square error on held-out windows, from the start's constants and from those found".into(),
            format!("claim: recovery within {:.0} %; dough: lower from every start, and lower than by random points", 100.0 * RECOVERED),
            claims,
        ],
    })
}
