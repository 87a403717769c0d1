//! Claim: in every long task — a strip cut in two, a word of three pieces, grains pushed into shapes, a dumpling's five tools — each model
//! that plans ends nearer to the goal than nothing moving does, and the simulator nearest.
//!
//! Command: `cargo run --release --bin experiments -- tasks`, about fifteen minutes. Table: `paper/tables/tasks.tex`. What was made, as
//! pictures: `gallery.html` in the folders below `runs/compare`.
use crate::adjudge::{NOBODY, WORLD, adjudge, lower};
use crate::claim::{Experiment, Rows, Size, compared, difference, trials};
use indexmap::IndexSet;
use pliant::compare::Row;
use pliant::table::{Grid, Interval, TrialRow};
use pliant::watch::Watch;
use serde_json::{Value, json};
use std::path::Path;

pub(crate) const CLAIM: Experiment = Experiment {
    name: "tasks",
    claim: "in cutting, spelling, pushing and a sequence of five tools every model that plans beats `still`, and the simulator is nearest",
    duration: "about 15 minutes",
    rows: Rows::Measured(measure),
    table,
};

/// Comparisons in `configs/compare`.
const TASKS: [&str; 4] = ["cut", "word", "pile", "dumpling"];
const SEEDS: &str = "seeds=[0, 1, 2, 3, 4]";
const SMOKE: [&str; 4] = ["seeds=[0]", "model=[oracle, still]", "actions=1", "budget.rollouts=2"];

fn measure(size: Size, _: &Path, watch: &Watch) -> anyhow::Result<Vec<Value>> {
    let words = if size == Size::Smoke { &SMOKE[..] } else { &[SEEDS][..] };
    let words: Vec<String> = words.iter().map(|word| (*word).to_owned()).collect();
    let mut rows = Vec::new();
    for task in TASKS {
        for mut row in compared(task, &words, watch)? {
            row["change"] = json!(task);
            rows.push(row);
        }
    }
    Ok(rows)
}

fn table(rows: &[Value]) -> anyhow::Result<Grid> {
    let trials = trials(rows)?;
    let distinct = |read: fn(&TrialRow) -> &str| trials.iter().map(read).collect::<IndexSet<&str>>();
    let tasks = distinct(|trial| &trial.change);
    let (planners, models) = (distinct(|trial| &trial.row.planner), distinct(|trial| &trial.row.model));
    let of = |task: &str, planner: &str, model: &str| -> Vec<&Row> {
        let own = |t: &&TrialRow| t.change == task && t.row.planner == planner && t.row.model == model;
        trials.iter().filter(own).map(|trial| &trial.row).filter(|row| row.achieved.is_some()).collect()
    };
    let (mut lines, mut against_still, mut against_oracle) = (Vec::new(), Vec::new(), Vec::new());
    for (task, planner) in tasks.iter().flat_map(|task| planners.iter().map(move |planner| (*task, *planner))) {
        let [still, oracle] = [NOBODY, WORLD].map(|model| of(task, planner, model));
        for model in &models {
            let mine = of(task, planner, model);
            let Some(first) = mine.first() else { continue };
            let mean = |value: fn(&Row) -> Option<f64>| {
                Interval::over_seeds(mine.iter().filter_map(|row| Some((row.seed, value(row)?))))
            };
            let (gain, regret) = (difference(&mine, &still), difference(&mine, &oracle));
            let label = format!("{task} / {planner} / {model}");
            if *model != NOBODY {
                against_still.push((label.clone(), lower(gain)));
            }
            if ![NOBODY, WORLD].contains(model) && !oracle.is_empty() {
                against_oracle.push((label, lower(difference(&oracle, &mine))));
            }
            lines.push(vec![
                task.to_owned(),
                planner.to_owned(),
                (*model).to_owned(),
                first.rollout.map_or("–".to_owned(), |error| format!("{:.2}", 1e3 * error)),
                Interval::millimetres(mean(|row| row.achieved)),
                Interval::millimetres(mean(|row| Some(row.achieved? - row.start))),
                Interval::millimetres(gain),
                Interval::millimetres(regret),
                Interval::shares(mean(|row| *row.metrics.get("iou")?)),
            ]);
        }
    }
    let header = [
        "task",
        "planner",
        "model",
        "rollout error [mm]",
        "achieved [mm]",
        "Δ start [mm]",
        "Δ still [mm]",
        "Δ oracle [mm]",
        "IoU",
    ];
    Ok(Grid {
        title: "Long tasks".into(),
        header: header.map(String::from).to_vec(),
        rows: lines,
        notes: vec![
            "achieved: Chamfer distance, mean ± 95 % interval over seeds, each the mean over the task's goals; one fit a model; Δ: minus \
             the cost before the first action, minus what planning with that model achieved, paired by goal and seed; negative is better; \
             the simulator has no gradient to descend along"
                .into(),
            adjudge("every model that plans achieves less cost than still", against_still),
            adjudge("the simulator achieves less cost than every model", against_oracle),
        ],
    })
}
