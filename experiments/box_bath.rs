//! Claim: a graph network trained on four recordings of a cube dropped into a bath predicts two others with less than a tenth of the
//! mean squared error of ballistic flight, and roots over the cube lower it.
//!
//! Command: `cargo run --release --bin experiments -- box_bath recordings=../shared/data/boxbath`, about 40 minutes. Table:
//! `paper/tables/box_bath.tex`.
use crate::claim::{Experiment, Rows, Size, number};
use pliant::compare::{self, ContenderSpec, RUNS};
use pliant::config;
use pliant::data::{Dataset, DatasetSpec, Episode, HELD_OUT, RECORDINGS, import, simulate};
use pliant::table::{Grid, Interval};
use pliant::train::{Evaluation, Split};
use pliant::watch::Watch;
use serde_json::{Value, json};
use std::path::Path;

pub(crate) const CLAIM: Experiment = Experiment {
    name: "box_bath",
    claim: "on recordings of a cube in a bath a graph network has less than a tenth of the error of ballistic flight",
    duration: "about 40 minutes",
    rows: Rows::Recorded(measure),
    table,
};

/// The models, files of `configs/model`.
const MODELS: [&str; 2] = ["bath", "bath_roots"];

/// Acceleration of gravity \[m/s²\].
const GRAVITY: f64 = 9.81;

fn measure(size: Size, recordings: &Path, watch: &Watch) -> anyhow::Result<Vec<Value>> {
    let folder = Path::new(RUNS).join("box_bath");
    let dataset = match size {
        Size::Paper if folder.join("metadata.json").exists() => Dataset::load(&folder)?,
        Size::Paper => import(recordings, RECORDINGS[0], &folder)?,
        Size::Smoke => {
            // The same scene in our own world, where nobody has recordings.
            let words = ["episodes=2", "steps=3", "scene.particles=60"].map(str::to_owned);
            let spec = config::load::<DatasetSpec>("configs/dataset/box_bath.toml".as_ref(), &words)?.spec;
            simulate(&spec, &folder.with_extension("smoke"), watch)?
        }
    };
    let folder = if size == Size::Paper { folder } else { folder.with_extension("smoke") };
    let seeds = if size == Size::Paper { 0..3 } else { 0..1 };
    let held_out = Split::of(&dataset, HELD_OUT).held_out;
    let mut rows = vec![json!({ "model": "ballistic flight", "mse": ballistic(&held_out) })];
    for model in MODELS {
        for seed in seeds.clone() {
            let mut words = vec![format!("train.bath.seed={seed}"), format!("dynamics.laws.0.seed={seed}")];
            if size == Size::Smoke {
                words.extend(["train.bath.steps=2", "train.bath.validation_horizon=2"].map(str::to_owned));
            }
            let spec = config::load::<ContenderSpec>(format!("configs/model/{model}.toml").as_ref(), &words)?.spec;
            let contender = compare::train(model, &spec, &folder, RUNS.as_ref(), watch)?;
            let Some(Evaluation { curve, still_curve, one_step, .. }) = contender.held_out else { continue };
            if rows.len() == 1 {
                rows.insert(0, json!({ "model": "persistence", "mse": per_coordinate(&still_curve) }));
            }
            let mse = per_coordinate(&curve);
            rows.push(json!({ "model": model, "seed": seed, "mse": mse, "one_step": one_step, "curve": curve }));
        }
    }
    Ok(rows)
}

/// The mean squared error of a coordinate over a rollout \[m²\], from root mean squares of distances after each step \[m\].
fn per_coordinate(curve: &[f64]) -> f64 {
    curve.iter().map(|error| error * error / 3.0).sum::<f64>() / curve.len() as f64
}

/// The same of particles that fly on from the first two frames under gravity alone, down to the floor.
fn ballistic(episodes: &[Episode]) -> f64 {
    let error = |episode: &Episode| {
        let h = episode.interval;
        let mut now = episode.states[1].clone();
        let mut sum = 0.0;
        for truth in &episode.states[2..] {
            for (x, v) in now.positions.iter_mut().zip(&mut now.velocities) {
                v.z -= h * GRAVITY;
                *x += h * *v;
                x.z = x.z.max(0.0);
            }
            let squares = now.positions.iter().zip(&truth.positions).map(|(x, y)| x.distance_squared(*y));
            sum += squares.sum::<f64>() / (3.0 * truth.len() as f64);
        }
        sum / (episode.states.len() - 2) as f64
    };
    episodes.iter().map(error).sum::<f64>() / episodes.len() as f64
}

fn table(rows: &[Value]) -> anyhow::Result<Grid> {
    let of = |model: &str| rows.iter().filter(move |row| row["model"] == model).collect::<Vec<_>>();
    let ballistic = of("ballistic flight").first().map_or(f64::NAN, |row| number(row, "mse"));
    let names = ["persistence", "ballistic flight"].into_iter().chain(MODELS);
    let lines = names.map(|name| {
        let rows = of(name);
        let interval = |key: &str, unit: f64| -> String {
            let pairs = rows.iter().filter_map(|row| Some((row["seed"].as_u64()?, unit * number(row, key))));
            Interval::over_seeds(pairs).map_or_else(|| "–".into(), |i| i.to_string())
        };
        let worst = rows.iter().map(|row| number(row, "mse") / ballistic).fold(0.0, f64::max);
        let mse = match rows[..] {
            [row] if row["seed"].is_null() => format!("{:.4}", number(row, "mse")),
            _ => interval("mse", 1.0),
        };
        vec![name.to_owned(), mse, format!("{worst:.3}"), interval("one_step", 1e3), rows.len().to_string()]
    });
    Ok(Grid {
        title: "A cube dropped into a bath".into(),
        header: ["model", "MSE [m²]", "÷ ballistic", "one step [mm]", "fits"].map(String::from).to_vec(),
        rows: lines.collect(),
        notes: vec![
            "MSE: mean squared error of a coordinate over rollouts of 150 steps of both validation recordings (Li et al. 2019), mean ± \
             95 % interval over fits"
                .into(),
            "÷ ballistic: of the worst fit; the claim is that it is below 0.1. No recording of those two chose anything".into(),
        ],
    })
}
