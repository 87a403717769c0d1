//! The bench that every contender stands on: one dataset, one set of starts and goals, one budget.
use super::attempt::{Attempt, Entry, attempt};
use super::disturbance::{Disturbance, DisturbanceSpec};
use super::policies::policies;
use super::{Artifacts, CompareSpec, Contender, Prediction, Row, Source, to_jsonl};
use crate::chooser::{Chooser, Lesson};
use crate::config::{Fingerprint, Loaded, fingerprint, write_whole};
use crate::data::{DatasetSpec, HELD_OUT, simulate};
use crate::metric::{METRICS, Metric, MetricSpec};
use crate::perception::Perception;
use crate::planner::{Planner, PlannerSpec};
use crate::problem::Clock;
use crate::state::Constants;
use crate::tool::{Tool, ToolSpec};
use crate::train::Split;
use crate::watch::Watch;
use crate::world::World;
use anyhow::Context;
use indexmap::IndexMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

/// What the seed of interactions is after that of the dataset.
const INTERACTIONS: u64 = 1000;

/// Everything a comparison made.
#[derive(Debug)]
pub struct Comparison {
    /// Where its files are.
    pub folder: PathBuf,
    /// How well each model predicts held-out episodes.
    pub predictions: Vec<Prediction>,
    /// All attempts, ordered by goal, seed, planner and model.
    pub attempts: Vec<Attempt>,
    /// Folder of every stage that fitted a model, by model and stage.
    pub stages: Vec<(String, String, PathBuf)>,
    /// Folder of what the chooser has learned, where it has learned anything.
    pub chooser: Option<PathBuf>,
}

impl Comparison {
    /// The result rows.
    pub fn rows(&self) -> Vec<Row> {
        self.attempts.iter().map(|a| a.row.clone()).collect()
    }
}

/// What all attempts of a comparison share.
pub(super) struct Bench<'a> {
    pub(super) spec: &'a CompareSpec,
    pub(super) tools: IndexMap<String, Box<dyn Tool>>,
    pub(super) planners: IndexMap<String, Box<dyn Planner>>,
    /// What models may be told of the scene that is planned in.
    pub(super) constants: Arc<Constants>,
    pub(super) perception: Box<dyn Perception>,
    pub(super) chooser: Box<dyn Chooser>,
    /// Metrics that are not always reported, by the name of their column.
    pub(super) metrics: IndexMap<String, Box<dyn Metric>>,
    pub(super) disturbance: Option<Box<dyn Disturbance>>,
    pub(super) clock: Clock<'a>,
    pub(super) commit: &'a str,
    pub(super) fingerprint: String,
}

/// Simulates what is missing, fits every contender that is not fitted yet, and says how well each predicts.
///
/// # Errors
/// An impossible spec, a damaged artifact, a failing fit, or a stop that was asked for; what was made stays and is reused.
pub fn fit(spec: &CompareSpec, watch: &Watch) -> anyhow::Result<(Vec<Contender>, Vec<Prediction>)> {
    let Fitted { contenders, predictions, .. } = fitted(&spec.rooted(), watch)?;
    Ok((contenders, predictions))
}

/// The contenders, and what they were fitted to.
pub(super) struct Fitted {
    data: Split,
    dataset: Fingerprint,
    pub(super) contenders: Vec<Contender>,
    predictions: Vec<Prediction>,
}

pub(super) fn fitted(spec: &CompareSpec, watch: &Watch) -> anyhow::Result<Fitted> {
    spec.check()?;
    let artifacts = Artifacts::below(&spec.artifacts);
    let (folder, mark) = artifacts.folder("dataset", &spec.dataset);
    let dataset = simulate(&spec.dataset, &folder, watch)?;
    let mut data = Split::of(&dataset, HELD_OUT);
    data.train.truncate(spec.learn_from.unwrap_or(usize::MAX));
    let dataset = fingerprint(&(mark, spec.learn_from));
    let there = interactions(spec, &artifacts, watch)?;
    let contenders = spec.model.iter().map(|(name, contender)| {
        let there = there.as_ref().map(|(data, mark)| (data, mark));
        contender.adapted(name, (&data, &dataset), there, &artifacts, watch)
    });
    let contenders = contenders.collect::<anyhow::Result<Vec<_>>>()?;
    let predictions = contenders.iter().filter_map(Prediction::of).collect();
    Ok(Fitted { data, dataset, contenders, predictions })
}

/// What may be learned from in the scene that is planned in, and its fingerprint.
fn interactions(
    spec: &CompareSpec,
    artifacts: &Artifacts,
    watch: &Watch,
) -> anyhow::Result<Option<(Split, Fingerprint)>> {
    let Some(episodes) = spec.interactions else { return Ok(None) };
    // Other random numbers than those of the dataset: nobody has seen these starts.
    let seed = spec.dataset.seed.wrapping_add(INTERACTIONS).wrapping_add(spec.interactions_seed);
    let there = DatasetSpec { episodes, seed, ..spec.planned().dataset };
    let (folder, mark) = artifacts.folder("dataset", &there);
    let dataset = simulate(&there, &folder, watch)?;
    Ok(Some((Split::of(&dataset, HELD_OUT), mark)))
}

/// Fits the one contender of `spec` that is called `name`, as [`fit`] does.
///
/// # Errors
/// As [`fit`]; also when the comparison has no such model.
pub fn fit_named(name: &str, spec: &CompareSpec, watch: &Watch) -> anyhow::Result<Contender> {
    let mut spec = spec.clone();
    let known = spec.model.keys().cloned().collect::<Vec<_>>().join(", ");
    spec.model.retain(|model, _| model == name);
    let (contenders, _) = if spec.model.is_empty() { Default::default() } else { fit(&spec, watch)? };
    contenders.into_iter().next().with_context(|| format!("the comparison has no model `{name}`; it has {known}"))
}

/// Fits every contender, then plans and executes every attempt that an earlier run has not.
///
/// Writes one file an attempt, `predictions.jsonl`, and when all is done `rows.jsonl`, whose presence says so.
///
/// # Errors
/// As [`fit`]; also a goal or start that cannot be made.
pub fn compare(loaded: &Loaded<CompareSpec>, commit: &str, watch: &Watch) -> anyhow::Result<Comparison> {
    let spec = &loaded.spec.planned();
    let fitted = fitted(&loaded.spec.rooted(), watch)?;
    let mark = identity(&loaded.spec);
    let folder = spec.out.clone().unwrap_or_else(|| spec.artifacts.join("compare").join(mark.to_string()));
    write_whole(&folder.join("config.toml"), loaded.resolved.to_toml().as_bytes())?;
    let lines = fitted.predictions.iter().map(|p| serde_json::to_string(p).expect("plain data") + "\n");
    write_whole(&folder.join("predictions.jsonl"), lines.collect::<String>().as_bytes())?;

    let began = Instant::now();
    let clock = move || began.elapsed().as_secs_f64();
    let (bench, Fitted { contenders, predictions, .. }) =
        Bench::new(spec, &clock, commit, mark.to_string(), fitted, watch)?;
    let attempts = bench.run(&contenders, &folder.join("attempts"), watch)?;
    let rows: Vec<Row> = attempts.iter().map(|a| a.row.clone()).collect();
    write_whole(&folder.join("rows.jsonl"), to_jsonl(&rows).as_bytes())?;
    let chooser = bench.chooser.folder().map(Path::to_owned);
    let stages = contenders.into_iter().flat_map(|c| {
        let name = c.name;
        c.stages.into_iter().map(move |(stage, folder)| (name.clone(), stage, folder))
    });
    Ok(Comparison { folder, predictions, attempts, stages: stages.collect(), chooser })
}

/// Fingerprint of everything that results depend on, which where they are written is not.
pub(super) fn identity(spec: &CompareSpec) -> Fingerprint {
    fingerprint(&CompareSpec { artifacts: PathBuf::new(), out: None, ..spec.clone() })
}

impl<'a> Bench<'a> {
    /// The bench, and the contenders with the policies that its planners ask for.
    pub(super) fn new(
        spec: &'a CompareSpec,
        clock: Clock<'a>,
        commit: &'a str,
        fingerprint: String,
        mut fitted: Fitted,
        watch: &Watch,
    ) -> anyhow::Result<(Self, Fitted)> {
        let (data, dataset) = (&fitted.data, &fitted.dataset);
        let build = |(name, tool): (&String, &ToolSpec)| {
            Ok((name.clone(), tool.clone().build().with_context(|| format!("the tool {name} cannot be built"))?))
        };
        let search = |(name, planner): (&String, &PlannerSpec)| Ok((name.clone(), planner.clone().build()?));
        let measure = |(name, metric): (&String, &MetricSpec)| Ok((name.clone(), metric.clone().build()?));
        let tools = spec.dataset.tool.iter().map(build).collect::<anyhow::Result<_>>()?;
        let lesson = Lesson { data, dataset, tools: &tools, root: &spec.artifacts, watch };
        let chooser = spec.chooser.clone().build()?.make(&lesson).context("the chooser cannot be made")?;
        let bench = Self {
            spec,
            tools,
            planners: spec.planner.iter().map(search).collect::<anyhow::Result<_>>()?,
            constants: spec.dataset.constants().into(),
            perception: spec.perception.clone().build()?,
            chooser,
            metrics: spec.metric.iter().map(measure).collect::<anyhow::Result<_>>()?,
            disturbance: spec.disturbance.clone().map(DisturbanceSpec::build).transpose()?,
            clock,
            commit,
            fingerprint,
        };
        if bench.planners.values().any(|planner| planner.wants_proposals()) {
            for contender in &mut fitted.contenders {
                contender.policies = policies(contender, spec, &bench.tools, (data, dataset), watch)?;
            }
        }
        Ok((bench, fitted))
    }

    /// Every metric that is reported, by the name of its column.
    pub(super) fn reported(&self) -> impl Iterator<Item = (&str, &dyn Metric)> {
        let always = METRICS.iter().map(|metric| (metric.name(), *metric));
        always.chain(self.metrics.iter().map(|(name, metric)| (name.as_str(), metric.as_ref())))
    }

    fn run(&self, contenders: &[Contender], folder: &Path, watch: &Watch) -> anyhow::Result<Vec<Attempt>> {
        let spec = self.spec;
        let total = spec.goal.len() * spec.seeds.len() * self.planners.len() * contenders.len();
        let bar = watch.stage("plan and execute", total as u64);
        let mut attempts = Vec::with_capacity(total);
        for (goal_name, goal) in &spec.goal {
            let maker = goal.clone().build().with_context(|| format!("the goal {goal_name} cannot be built"))?;
            for &seed in &spec.seeds {
                let start = self.start(seed)?;
                let source = Source { start: &start, dataset: &spec.dataset, root: &spec.data.root, seed };
                let goal = maker.make(&source).with_context(|| format!("the goal {goal_name} cannot be made"))?;
                let floors = goal.floors(self.reported());
                let pairs = self.planners.iter().flat_map(|planner| contenders.iter().map(move |each| (planner, each)));
                let entries = pairs.map(|((planner_name, planner), contender)| Entry {
                    contender,
                    planner: (planner_name, planner.as_ref()),
                    goal: (goal_name, &goal),
                    floors: &floors,
                    seed,
                    start: &start,
                });
                // As many at a time as can execute side by side: no more are lost when the run is cut short.
                for some in entries.collect::<Vec<_>>().chunks(rayon::current_num_threads()) {
                    watch.go_on(|| "stopped; the same command goes on where it stopped".to_owned())?;
                    bar.set_message(format!("{goal_name} {} {}", some[0].planner.0, some[0].contender.name));
                    attempts.extend(self.recall(some, folder)?);
                    bar.inc(some.len() as u64);
                }
            }
        }
        bar.finish_and_clear();
        Ok(attempts)
    }

    /// The attempts as an earlier run of the same config left them, or made now.
    fn recall(&self, entries: &[Entry<'_>], folder: &Path) -> anyhow::Result<Vec<Attempt>> {
        let path = |entry: &Entry<'_>| {
            let folder = folder.join(entry.goal.0).join(entry.seed.to_string()).join(entry.planner.0);
            folder.join(format!("{}.json", entry.contender.name))
        };
        let known = entries.iter().map(|entry| self.read(&path(entry))).collect::<anyhow::Result<Vec<_>>>()?;
        let missing: Vec<&Entry<'_>> =
            entries.iter().zip(&known).filter(|(_, k)| k.is_none()).map(|(e, _)| e).collect();
        let made = attempt(self, &missing)?;
        for (entry, attempt) in missing.iter().zip(&made) {
            write_whole(&path(entry), serde_json::to_string(attempt).expect("plain data").as_bytes())?;
        }
        let mut made = made.into_iter();
        let all = known.into_iter().map(|known| known.or_else(|| made.next()));
        Ok(all.map(|attempt| attempt.expect("what was missing was made")).collect())
    }

    /// The attempt that an earlier run of the same config wrote, if there is one.
    fn read(&self, path: &Path) -> anyhow::Result<Option<Attempt>> {
        if !path.exists() {
            return Ok(None);
        }
        let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
        let read: Attempt = serde_json::from_str(&text)
            .with_context(|| format!("{} is damaged; delete it to attempt again", path.display()))?;
        Ok(Some(read).filter(|read| read.row.fingerprint == self.fingerprint))
    }

    pub(super) fn start(&self, seed: u64) -> anyhow::Result<World> {
        let Some(start) = &self.spec.start else { return World::new(&self.spec.dataset.scene, seed) };
        start.rebuild(&self.spec.data.root, &self.spec.dataset.scene)
    }
}
