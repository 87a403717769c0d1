//! One model at work on one goal, action by action, with everything kept that one may want to look at.
use super::attempt::Entry;
use super::bench::{Bench, fitted, identity};
use super::run::Run;
use super::{CompareSpec, Contender, Source};
use crate::config::{Loaded, write_whole};
use crate::data::{DatasetSpec, Episode, store};
use crate::watch::Watch;
use anyhow::Context;
use glam::DVec3;
use indexmap::IndexMap;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// One action on the way; a line of `plan.jsonl`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Step {
    /// Its number, from 1.
    pub action: usize,
    /// Name of the tool.
    pub tool: String,
    /// θ by name, in \[m\] and of angles in \[rad\].
    pub theta: IndexMap<String, f64>,
    /// Cost that the model promised for the end of its plan \[m\].
    pub predicted: f64,
    /// Cost of what the world made of the action, before anything disturbed it \[m\].
    pub achieved: f64,
    /// Wall seconds spent planning it; 0 where an earlier plan described it.
    pub seconds: f64,
    /// Rollouts spent planning it.
    pub rollouts: usize,
    /// Gradients spent planning it.
    pub gradients: usize,
}

/// All of it.
#[derive(Clone, Debug)]
pub struct Journey {
    /// Where its files are.
    pub folder: PathBuf,
    /// Who planned how for what: the names of model, planner and goal.
    pub names: [String; 3],
    /// Cost before the first action \[m\].
    pub start: f64,
    /// The actions.
    pub steps: Vec<Step>,
    /// Points of the goal \[m\].
    pub goal: Vec<DVec3>,
    /// Particles before the first action and after each \[m\].
    pub shapes: Vec<Vec<DVec3>>,
}

/// Fits the first model of a comparison, and has it plan with the first planner for the first goal from the first seed: observe,
/// choose a tool, plan, execute, and again, until the cost is at most `until` or the actions are used up.
///
/// `tell` hears of every action when it is done. Writes `config.toml`, `plan.jsonl`, and the episodes as a dataset.
///
/// # Errors
/// As [`super::compare`]; also when `tell` fails.
pub fn plan(
    loaded: &Loaded<CompareSpec>,
    watch: &Watch,
    tell: &mut dyn FnMut(&Step) -> anyhow::Result<()>,
) -> anyhow::Result<Journey> {
    let mut spec = loaded.spec.clone();
    spec.model.truncate(1);
    spec.planner.truncate(1);
    spec.goal.truncate(1);
    spec.seeds.truncate(1);
    let fitted = fitted(&spec.rooted(), watch)?;
    let mark = identity(&spec);
    let spec = spec.planned();
    let folder = spec.out.clone().unwrap_or_else(|| spec.artifacts.join("plan").join(mark.to_string()));
    write_whole(&folder.join("config.toml"), loaded.resolved.to_toml().as_bytes())?;
    let began = Instant::now();
    let clock = move || began.elapsed().as_secs_f64();
    let (bench, fitted) = Bench::new(&spec, &clock, "", mark.to_string(), fitted, watch)?;
    let mut journey = travel(&bench, &fitted.contenders[0], &folder, watch, tell)?;
    journey.folder = folder;
    Ok(journey)
}

fn travel(
    bench: &Bench<'_>,
    contender: &Contender,
    folder: &Path,
    watch: &Watch,
    tell: &mut dyn FnMut(&Step) -> anyhow::Result<()>,
) -> anyhow::Result<Journey> {
    let spec = bench.spec;
    let nothing = "nothing was checked to be there";
    let (goal_name, goal) = spec.goal.first().context(nothing)?;
    let (planner_name, planner) = bench.planners.first().context(nothing)?;
    let seed = *spec.seeds.first().context(nothing)?;
    let start = bench.start(seed)?;
    let source = Source { start: &start, dataset: &spec.dataset, root: &spec.data.root, seed };
    let goal = goal.clone().build()?.make(&source).with_context(|| format!("the goal {goal_name} cannot be made"))?;
    let floors = goal.floors(bench.reported());
    let entry = Entry {
        contender,
        planner: (planner_name, planner.as_ref()),
        goal: (goal_name, &goal),
        floors: &floors,
        seed,
        start: &start,
    };
    let mut run = Run::new(bench, &entry)?;
    let mut journey = Journey {
        folder: PathBuf::new(),
        names: [contender.name.clone(), planner_name.clone(), goal_name.clone()],
        start: run.cost(),
        steps: Vec::new(),
        goal: goal.points.clone(),
        shapes: vec![start.particles().positions],
    };
    let (mut episodes, mut lines) = (Vec::new(), String::new());
    for action in 0..spec.actions as u64 {
        watch.go_on(|| "stopped between two actions".to_owned())?;
        let before = run.spent();
        let Some(act) = run.plan(action)? else { break };
        let after = run.spent();
        let piece = run.piece(action);
        let states = run.act(&act);
        let step = Step {
            action: action as usize + 1,
            theta: bench.tools[&act.tool].space(&piece).names.into_iter().zip(act.theta.clone()).collect(),
            predicted: run.predicted().unwrap_or(f64::NAN),
            achieved: run.cost(),
            seconds: after.seconds - before.seconds,
            rollouts: after.rollouts - before.rollouts,
            gradients: after.gradients - before.gradients,
            tool: act.tool.clone(),
        };
        journey.shapes.push(states.last().map(|x| x.positions.clone()).unwrap_or_default());
        episodes.push(Episode {
            tool: format!("{}_{}", action + 1, act.tool),
            theta: act.theta,
            interval: start.interval(),
            start: act.motion.start,
            controls: act.motion.controls,
            states,
            body: start.pieces().into_iter().map(|piece| piece as u32).collect(),
            walls: start.walls().into(),
            constants: bench.constants.clone(),
        });
        lines += &(serde_json::to_string(&step).expect("plain data") + "\n");
        write_whole(&folder.join("plan.jsonl"), lines.as_bytes())?;
        tell(&step)?;
        journey.steps.push(step);
        run.disturb(action);
    }
    if !episodes.is_empty() {
        let tools = episodes
            .iter()
            .zip(&journey.steps)
            .map(|(e, step)| (e.tool.clone(), spec.dataset.tool[&step.tool].clone()));
        // A dataset that consists of these episodes, each with the tool of its turn.
        let told = DatasetSpec { episodes: episodes.len(), tool: tools.collect(), ..spec.dataset.clone() };
        store(&told, &episodes, &folder.join("episodes"))?;
    }
    Ok(journey)
}
