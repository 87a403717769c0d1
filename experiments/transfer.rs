//! Models fitted to some episodes and judged on others: of another size, material or tool, or after fewer minutes of data.
use crate::claim::{median, number};
use crate::cpu::cpu_seconds;
use anyhow::Context;
use indexmap::IndexSet;
use pliant::compare::{Artifacts, Contender, ContenderSpec, RUNS, dataset_folder};
use pliant::config::{self, Fingerprint, fingerprint};
use pliant::data::{Dataset, DatasetSpec, Episode, HELD_OUT, simulate};
use pliant::model::WorldModel;
use pliant::state::ToolShape;
use pliant::table::{Grid, Interval, verdict};
use pliant::train::{Evaluation, Split, Tools, evaluate};
use pliant::watch::Watch;
use serde_json::{Value, json};
use std::path::Path;
use std::sync::Arc;

/// Most episodes of a dataset that its own models are judged on.
const JUDGED_ON: usize = 48;

/// A model of `configs/model` and changes to it.
pub(crate) type Model<'a> = (&'a str, &'a [&'a str]);

/// Episodes to learn from.
pub(crate) struct Lesson {
    /// What the table calls them; their minutes a tool, unless something else is said.
    name: String,
    /// Those that fits see, and those of the same kind that they do not.
    split: Split,
    mark: Fingerprint,
}

/// Episodes to be judged on, none of which any fit sees.
pub(crate) struct Exam {
    name: String,
    episodes: Vec<Episode>,
    tools: Tools,
}

/// The dataset of a config of `configs/dataset` with these changes, drawn where it is not there yet.
pub(crate) fn dataset(name: &str, words: &[&str], watch: &Watch) -> anyhow::Result<Dataset> {
    let words: Vec<String> = words.iter().map(|word| (*word).to_owned()).collect();
    let spec = config::load::<DatasetSpec>(format!("configs/dataset/{name}.toml").as_ref(), &words)?.spec;
    simulate(&spec, &dataset_folder(RUNS.as_ref(), &spec), watch)
}

impl Lesson {
    /// The first `count` of a dataset's training episodes.
    pub(crate) fn of(dataset: &Dataset, count: usize) -> Self {
        let mut split = Split::of(dataset, HELD_OUT);
        let count = count.min(split.train.len());
        split.train.truncate(count);
        split.held_out.truncate(JUDGED_ON);
        let seconds: f64 = split.train.iter().map(|e| e.interval * e.controls.len() as f64).sum();
        let name = format!("{:.2} min a tool", seconds / 60.0 / split.tools.len() as f64);
        Self { name, split, mark: fingerprint(&(&dataset.metadata, count)) }
    }

    /// The model, fitted to the lesson with every random stream of its own for each seed.
    pub(crate) fn teach(&self, (name, words): &Model<'_>, seed: u64, watch: &Watch) -> anyhow::Result<Contender> {
        let words: Vec<String> = words.iter().map(|word| (*word).to_owned()).collect();
        let spec = config::load::<ContenderSpec>(format!("configs/model/{name}.toml").as_ref(), &words)?.spec;
        let spec: ContenderSpec = serde_json::from_value(seeded(serde_json::to_value(spec)?, seed))?;
        spec.fit(name, &self.split, &self.mark, &Artifacts::below(Path::new(RUNS)), watch)
    }

    /// An episode that no fit sees, and the shape of its tool.
    pub(crate) fn unseen(&self) -> (&Episode, &Arc<ToolShape>) {
        let episode = &self.split.held_out[0];
        (episode, &self.split.tools[&episode.tool])
    }

    /// What the table calls them.
    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// The same, which the table calls otherwise.
    pub(crate) fn called(self, name: String) -> Self {
        Self { name, ..self }
    }
}

impl Exam {
    /// All episodes of a dataset.
    pub(crate) fn of(name: impl Into<String>, dataset: Dataset) -> Self {
        Self { name: name.into(), episodes: dataset.episodes, tools: dataset.tools }
    }
}

/// A row for every model, seed and exam, what the lesson's own dataset holds out being the first; every random stream of a fit is drawn
/// anew for each seed.
pub(crate) fn judged(
    models: &[Model<'_>],
    lesson: &Lesson,
    exams: &[Exam],
    seeds: u64,
    watch: &Watch,
) -> anyhow::Result<Vec<Value>> {
    let mut rows = Vec::new();
    for model in models {
        for seed in 0..seeds {
            watch.go_on(|| "stopped between two fits; the same command goes on".to_owned())?;
            let (name, fitted) = (model.0, lesson.teach(model, seed, watch)?);
            let cost = step_cost(fitted.model.as_ref(), &lesson.split)?;
            let own = fitted.held_out.with_context(|| format!("{name} cannot start from a recording"))?;
            let mut add = |exam: &str, told: &Evaluation| {
                rows.push(json!({ "lesson": lesson.name, "exam": exam, "model": name, "seed": seed,
                    "one_step": told.one_step, "rollout": told.rollout, "still_rollout": told.still_rollout,
                    "episodes": told.episodes, "not_finite": told.not_finite, "step_seconds": cost }));
            };
            add("the same", &own);
            for exam in exams {
                let told = evaluate(fitted.model.as_ref(), &exam.episodes, &exam.tools);
                add(&exam.name, &told.with_context(|| format!("judging {name} on {}", exam.name))?);
            }
        }
    }
    Ok(rows)
}

/// Time of one thread that predicting a control step takes, the mean over an episode \[s\].
fn step_cost(model: &dyn WorldModel, split: &Split) -> anyhow::Result<f64> {
    let episode = &split.held_out[0];
    let scene = episode.scene(0, &split.tools[&episode.tool]);
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    alone.install(|| {
        let clock = cpu_seconds()?;
        let rollout = model.rollout(&scene, &episode.controls);
        Ok((cpu_seconds()? - clock) / (rollout.len() - 1) as f64)
    })
}

/// The same with every key `seed`, however deep, being `seed`.
fn seeded(value: Value, seed: u64) -> Value {
    let of = |(key, value): (String, Value)| {
        let value = if key == "seed" { json!(seed) } else { seeded(value, seed) };
        (key, value)
    };
    match value {
        Value::Object(members) => members.into_iter().map(of).collect(),
        Value::Array(items) => items.into_iter().map(|item| seeded(item, seed)).collect(),
        other => other,
    }
}

/// Two models that were judged after the same lesson, and the first's rollout error minus the second's, paired by seed.
pub(crate) struct Duel<'a> {
    pub(crate) lesson: &'a str,
    pub(crate) exam: &'a str,
    pub(crate) mine: &'a str,
    pub(crate) theirs: &'a str,
    pub(crate) difference: Option<Interval>,
}

/// All pairs of a model that is claimed to err less and one that is claimed to err more.
pub(crate) fn duels<'a>(
    rows: &'a [Value],
    mine: impl Fn(&str) -> bool,
    theirs: impl Fn(&str) -> bool,
) -> Vec<Duel<'a>> {
    let text = |row: &'a Value, key: &str| row[key].as_str().unwrap_or("–");
    let keys: IndexSet<[&str; 3]> =
        rows.iter().map(|row| ["lesson", "exam", "model"].map(|key| text(row, key))).collect();
    // A rollout that was not finite is null: no error, and no difference.
    let errors = |key: &[&str; 3]| {
        let own = rows.iter().filter(|row| ["lesson", "exam", "model"].map(|key| text(row, key)) == *key);
        own.map(|row| (row["seed"].as_u64().unwrap_or(0), number(row, "rollout"))).collect::<Vec<_>>()
    };
    let pairs = keys.iter().flat_map(|a| keys.iter().map(move |b| (a, b)));
    let pairs = pairs.filter(|(a, b)| a[..2] == b[..2] && mine(a[2]) && theirs(b[2]));
    let duel = |(a, b): (&[&'a str; 3], &[&'a str; 3])| {
        let others = errors(b);
        let both = errors(a).into_iter().filter_map(|(seed, x)| {
            let (_, y) = others.iter().find(|(other, _)| *other == seed)?;
            Some((seed, x - y))
        });
        Duel { lesson: a[0], exam: a[1], mine: a[2], theirs: b[2], difference: Interval::over_seeds(both) }
    };
    pairs.map(duel).collect()
}

const NOTES: [&str; 2] = [
    "a step: time of one thread to predict a control step, the median over fits",
    "not finite: predictions that were not, of all fits; one such makes the mean unknown",
];

/// One line a lesson, exam and model, each minus the model that `references` says, paired by seed.
pub(crate) fn lines(title: &str, rows: &[Value], reference: impl Fn(&str) -> bool) -> Grid {
    let text = |row: &Value, key: &str| row[key].as_str().unwrap_or("–").to_owned();
    let key = |row: &Value| ["lesson", "exam", "model"].map(|key| text(row, key));
    let mut keys: Vec<[String; 3]> = Vec::new();
    rows.iter().map(key).for_each(|key| {
        if !keys.contains(&key) {
            keys.push(key)
        }
    });
    let of = |wanted: &[String; 3]| rows.iter().filter(|row| key(row) == *wanted).collect::<Vec<_>>();
    // JSON has no infinity: a rollout that was not finite is written as null.
    let seeds = |rows: &[&Value], key: &str| -> Vec<(u64, f64)> {
        rows.iter().map(|row| (row["seed"].as_u64().unwrap_or(0), row[key].as_f64().unwrap_or(f64::INFINITY))).collect()
    };
    let share = |rows: &[&Value]| -> Vec<(u64, f64)> {
        let still = |(row, (seed, rollout)): (&&Value, (u64, f64))| (seed, rollout / number(row, "still_rollout"));
        rows.iter().zip(seeds(rows, "rollout")).map(still).collect()
    };
    let against = |[lesson, exam, model]: &[String; 3]| -> Option<Interval> {
        let base = keys.iter().find(|key| key[0] == *lesson && key[1] == *exam && reference(&key[2]))?;
        let (mine, base) = (of(&[lesson.clone(), exam.clone(), model.clone()]), seeds(&of(base), "rollout"));
        let mine = seeds(&mine, "rollout").into_iter().zip(base);
        (!reference(model)).then(|| Interval::over_seeds(mine.map(|((seed, x), (_, y))| (seed, x - y)))).flatten()
    };
    let line = |key: &[String; 3]| {
        let rows = of(key);
        let delta = if reference(&key[2]) { "reference".to_owned() } else { Interval::millimetres(against(key)) };
        let mut cells = key.to_vec();
        cells.extend([
            Interval::millimetres(Interval::over_seeds(seeds(&rows, "one_step"))),
            Interval::millimetres(Interval::over_seeds(seeds(&rows, "rollout"))),
            Interval::shares(Interval::over_seeds(share(&rows))),
            delta,
            format!("{:.1}", 1e3 * median(rows.iter().map(|row| number(row, "step_seconds")).collect())),
            rows.iter().map(|row| row["not_finite"].as_u64().unwrap_or(0)).sum::<u64>().to_string(),
        ]);
        cells
    };
    let mut blocks: Vec<[String; 2]> = Vec::new();
    for [lesson, exam, _] in &keys {
        let block = [lesson.clone(), exam.clone()];
        if !blocks.contains(&block) {
            blocks.push(block);
        }
    }
    let within = |block: &[String; 2]| keys.iter().filter(|key| key[..2] == *block).collect::<Vec<_>>();
    let said = blocks.iter().map(|block| {
        let labelled = within(block).into_iter().map(|key| (key[2].clone(), against(key)));
        format!("rollout error against the reference, learned from {}, {}: {}", block[0], block[1], verdict(labelled))
    });
    let header = [
        "learned from",
        "judged on",
        "model",
        "one step [mm]",
        "rollout [mm]",
        "÷ still",
        "Δ reference [mm]",
        "a step [ms]",
        "not finite",
    ];
    let fits = rows.iter().filter_map(|row| row["seed"].as_u64()).max().map_or(0, |seed| seed + 1);
    Grid {
        title: title.to_owned(),
        header: header.map(String::from).to_vec(),
        rows: blocks.iter().flat_map(within).map(line).collect(),
        notes: [format!(
            "one step, rollout: root mean square error over particles and episodes that no fit has seen, mean ± 95 % interval over {fits} \
             fits; ÷ still: the rollout's over that of a model in which nothing moves; Δ reference: paired by seed"
        )]
        .into_iter()
        .chain(said)
        .chain(NOTES.map(str::to_owned))
        .collect(),
    }
}
