//! Claim: a classifier of the workpiece and its goal, which plans at most three of fifteen tools, costs at most a tenth more than planning
//! all of them, and less than one tool for every goal or a random one.
//!
//! Command: `cargo run --release --bin experiments -- tool_choice`, about half an hour, the episodes included. Table:
//! `paper/tables/tool_choice.tex`.
use crate::adjudge::{NO_WORSE, NOBODY, adjudge, lower};
use crate::claim::{Experiment, Rows, SMALL_FITS, Size, median, number, read};
use anyhow::{Context, ensure};
use pliant::compare::{CompareSpec, Comparison, commit, compare};
use pliant::config::{self, Loaded};
use pliant::table::{Grid, Interval, verdict};
use pliant::train::classifier::{REPORT, Report};
use pliant::watch::Watch;
use serde_json::{Value, json};
use std::path::Path;

pub(crate) const CLAIM: Experiment = Experiment {
    name: "tool_choice",
    claim: "three tools that a classifier thinks likely cost a tenth more than all fifteen at most, less than one or a random one",
    duration: "about 30 minutes",
    rows: Rows::Measured(measure),
    table,
};

/// Seeds of the goals by which the best tool for all of them is chosen; the table's are others.
const TRAINING: &str = "seeds=[100,101,102,103,104]";
/// What the others are compared with.
const REFERENCE: &str = "exhaustive";
/// Pairs of tools that the table names.
const CONFUSED: usize = 5;

fn load(size: Size, words: &[&str]) -> anyhow::Result<Loaded<CompareSpec>> {
    let smoke = [&["dataset=smoke", "goal=[pressed]", "budget.rollouts=4"], &SMALL_FITS[..2]].concat();
    let small = if size == Size::Smoke { &smoke[..] } else { &[] };
    let words: Vec<String> = small.iter().chain(words).map(|word| (*word).to_owned()).collect();
    Ok(config::load("configs/compare/tool_choice.toml".as_ref(), &words)?)
}

fn mean_achieved(comparison: &Comparison) -> f64 {
    let costs: Vec<f64> = comparison.rows().iter().filter_map(|row| row.achieved).collect();
    costs.iter().sum::<f64>() / costs.len() as f64
}

fn measure(size: Size, _: &Path, watch: &Watch) -> anyhow::Result<Vec<Value>> {
    let (training, held_out) = match size {
        Size::Paper => (TRAINING, "seeds=[0,1,2,3,4]"),
        Size::Smoke => ("seeds=[100]", "seeds=[0]"),
    };
    let tools: Vec<String> = load(size, &["chooser=random"])?.spec.dataset.tool.keys().cloned().collect();
    let (mut rows, mut best) = (Vec::new(), (f64::INFINITY, String::new()));
    for tool in &tools {
        let fixed = format!("chooser.tool={tool}");
        let tried = compare(
            &load(size, &["~model.still", "~model.learned", training, "chooser=fixed", &fixed])?,
            &commit(),
            watch,
        )?;
        let cost = mean_achieved(&tried);
        rows.push(json!({ "part": "training", "tool": tool, "achieved": cost }));
        if cost < best.0 {
            best = (cost, tool.clone());
        }
    }
    let fixed = format!("chooser.tool={}", best.1);
    let quick = if size == Size::Smoke { "+chooser.network={steps: 3, width: 8}" } else { held_out };
    let choosers: [(&str, &[&str]); 4] = [
        ("classifier", &["chooser=classifier", quick]),
        (REFERENCE, &["chooser=exhaustive"]),
        ("fixed best", &["chooser=fixed", &fixed]),
        ("random", &["chooser=random"]),
    ];
    for (chooser, words) in choosers {
        let tried = compare(&load(size, &[&[held_out], words].concat())?, &commit(), watch)?;
        rows.extend(tried.rows().iter().map(|row| {
            json!({ "part": "plan", "chooser": chooser, "model": row.model, "goal": row.goal, "seed": row.seed,
                "achieved": row.achieved, "start": row.start, "predicted": row.predicted, "rollouts": row.rollouts,
                "seconds": row.seconds, "tools": row.tools, "commit": row.commit })
        }));
        if let Some(folder) = &tried.chooser {
            let mut report: Value = serde_json::from_str(&read(&folder.join(REPORT))?)?;
            report["part"] = json!("classifier");
            rows.push(report);
        }
    }
    Ok(rows)
}

fn table(rows: &[Value]) -> anyhow::Result<Grid> {
    let of = |part: &str| rows.iter().filter(|row| row["part"] == part).collect::<Vec<_>>();
    let (plans, training) = (of("plan"), of("training"));
    ensure!(!plans.is_empty(), "there are no rows");
    let mut keys: Vec<[&Value; 2]> = Vec::new();
    for key in plans.iter().map(|row| [&row["model"], &row["chooser"]]) {
        if !keys.contains(&key) {
            keys.push(key);
        }
    }
    keys.sort_by_key(|key| plans.iter().position(|row| row["model"] == *key[0]));
    let own = |key: &[&Value; 2]| -> Vec<&Value> {
        plans.iter().filter(|row| row["model"] == *key[0] && row["chooser"] == *key[1]).copied().collect()
    };
    let seed = |row: &Value| row["seed"].as_u64().unwrap_or(0);
    let beside = |key: &[&Value; 2], times: f64, chooser: &str| {
        let reference: Vec<&Value> =
            plans.iter().filter(|row| row["model"] == *key[0] && row["chooser"] == chooser).copied().collect();
        Interval::over_seeds(own(key).into_iter().filter_map(|row| {
            let other = reference.iter().find(|other| other["goal"] == row["goal"] && other["seed"] == row["seed"])?;
            Some((seed(row), row["achieved"].as_f64()? - times * other["achieved"].as_f64()?))
        }))
    };
    let against = |key: &[&Value; 2]| beside(key, 1.0, REFERENCE);
    let asked = keys.iter().filter(|key| key[0] != NOBODY && key[1] == "classifier");
    let claims = asked.flat_map(|key| {
        [(REFERENCE, NO_WORSE), ("fixed best", 1.0), ("random", 1.0)].map(|(chooser, times)| {
            let factor = if times == 1.0 { String::new() } else { format!("{times} × ") };
            let label = format!("{}: {factor}{chooser}", key[0].as_str().unwrap_or("–"));
            (label, lower(beside(key, times, chooser)))
        })
    });
    let claims = adjudge("the classifier achieves less cost", claims);
    let word = |value: &Value| value.as_str().unwrap_or("–").to_owned();
    let line = |key: &[&Value; 2]| {
        let mine = own(key);
        let over = |read: &dyn Fn(&Value) -> f64| Interval::over_seeds(mine.iter().map(|row| (seed(row), read(row))));
        let delta = if key[1] == REFERENCE { "reference".to_owned() } else { Interval::millimetres(against(key)) };
        vec![
            word(key[0]),
            word(key[1]),
            Interval::millimetres(over(&|row| number(row, "achieved"))),
            Interval::millimetres(over(&|row| number(row, "achieved") - number(row, "start"))),
            delta,
            format!("{:.0}", median(mine.iter().map(|row| number(row, "rollouts")).collect())),
            format!("{:.2}", median(mine.iter().map(|row| number(row, "seconds")).collect())),
        ]
    };
    let others = keys.iter().filter(|key| key[1] != REFERENCE);
    let said = verdict(others.map(|key| (format!("{} ({})", word(key[1]), word(key[0])), against(key))));
    let report = of("classifier").first().copied().context("the rows hold no report of the classifier")?;
    let report: Report = serde_json::from_value(report.clone())?;
    let bins = report.reliability.iter().map(|b| format!("{:.2} → {:.2} ({})", b.confidence, b.accuracy, b.count));
    let best = training.iter().min_by(|a, b| number(a, "achieved").total_cmp(&number(b, "achieved")));
    let header = ["model", "chooser", "achieved [mm]", "Δ start [mm]", "Δ exhaustive [mm]", "rollouts", "seconds"];
    Ok(Grid {
        title: "Which tool".into(),
        header: header.map(String::from).to_vec(),
        rows: keys.iter().map(line).collect(),
        notes: vec![
            "achieved: mean ± 95 % interval over seeds, each the mean over three goals of hidden actions of random tools; Δ exhaustive: \
             paired by goal and seed; rollouts, seconds: median a plan, in which every tool has a search of its own; the simulator \
             does not plan all tools, for its price"
                .into(),
            format!("achieved cost against planning every tool: {said}"),
            format!(
                "the classifier on {} held-out episodes of {} tools: top-1 {:.3}, top-3 {:.3}, expected calibration error {:.3}; \
                 confidence → accuracy (episodes): {}",
                report.episodes,
                report.tools.len(),
                report.top_1,
                report.top_3,
                report.calibration_error,
                bins.collect::<Vec<_>>().join(", ")
            ),
            format!("most often confused, an episode's tool → the one thought most probable (episodes): {}", confused(&report)),
            claims,
            format!(
                "fixed best: {}, which achieves most with the analytic model on goals of other seeds",
                best.map_or("–".to_owned(), |row| word(&row["tool"]))
            ),
        ],
    })
}

/// The pairs of tools that a classifier mistakes most often, the first for the second.
fn confused(report: &Report) -> String {
    let places = (0..report.tools.len()).flat_map(|k| (0..report.tools.len()).map(move |said| (k, said)));
    let mut pairs: Vec<(usize, usize, usize)> =
        places.filter(|(k, said)| k != said).map(|(k, said)| (report.confusion[k][said], k, said)).collect();
    pairs.sort_by_key(|(count, ..)| std::cmp::Reverse(*count));
    let told = pairs.iter().take(CONFUSED).filter(|(count, ..)| *count > 0);
    let told = told.map(|(count, k, said)| format!("{} → {} ({count})", report.tools[*k], report.tools[*said]));
    told.collect::<Vec<_>>().join(", ")
}
