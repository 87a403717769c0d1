//! One attempt: a model, a planner, a goal and a seed, from the first observation to the last action.
use super::{Bench, Contender, ControlSpec, Goal, Row};
use crate::chooser::Task;
use crate::metric::{GoalCost, METRICS, Metric};
use crate::model::{Cost, WorldModel};
use crate::perception::Observation;
use crate::planner::Planner;
use crate::problem::Spent;
use crate::state::{Particles, Pose, Scene, ToolShape, stream};
use crate::tool::{Motion, Workpiece};
use crate::world::World;
use anyhow::Context;
use glam::DVec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A result row and the shapes behind it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Attempt {
    /// The numbers.
    pub row: Row,
    /// Particles before the first action \[m\].
    pub start: Vec<DVec3>,
    /// Points of the goal \[m\].
    pub goal: Vec<DVec3>,
    /// Particles after the last action \[m\].
    pub achieved: Vec<DVec3>,
}

/// First word of every stream that perception draws from.
const PERCEIVING: u64 = u64::from_le_bytes(*b"perceive");

/// Who attempts what.
pub(super) struct Entry<'a> {
    pub(super) contender: &'a Contender,
    pub(super) planner: (&'a str, &'a dyn Planner),
    pub(super) goal: (&'a str, &'a Goal),
    pub(super) seed: u64,
    pub(super) start: &'a World,
}

/// Observe, choose tool and motion, execute, and again for every action.
///
/// The entries plan one after the other, for their seconds are compared, and then execute side by side.
pub(super) fn attempt(bench: &Bench<'_>, entries: &[&Entry<'_>]) -> anyhow::Result<Vec<Attempt>> {
    let mut runs = entries.iter().map(|entry| Run::new(bench, entry)).collect::<anyhow::Result<Vec<_>>>()?;
    for action in 0..bench.spec.actions as u64 {
        let mut planned = Vec::new();
        for run in &mut runs {
            let next = run.plan(action).with_context(|| {
                let Entry { contender, planner, goal, .. } = run.entry;
                format!("planning with {} and {} to {}", contender.name, planner.0, goal.0)
            })?;
            planned.extend(next.map(|(shape, motion)| (&mut run.world, shape, motion)));
        }
        planned.into_par_iter().for_each(|(world, shape, motion)| {
            world.execute(&shape, &motion);
        });
    }
    Ok(runs.iter().map(Run::result).collect())
}

/// An attempt under way.
struct Run<'a> {
    bench: &'a Bench<'a>,
    entry: &'a Entry<'a>,
    cost: GoalCost,
    world: World,
    start: Particles,
    tools: Vec<String>,
    actions: Vec<Vec<f64>>,
    spent: Spent,
    /// What the last plan promised; none as long as there was none.
    predicted: Option<f64>,
    /// Where the model thinks that the last action ends, in open loop.
    imagined: Option<Particles>,
}

impl<'a> Run<'a> {
    fn new(bench: &'a Bench<'a>, entry: &'a Entry<'a>) -> anyhow::Result<Self> {
        let world = entry.start.clone();
        Ok(Self {
            bench,
            entry,
            cost: GoalCost::new(bench.spec.cost.clone().build()?, entry.goal.1.points.clone())?,
            start: world.particles(),
            world,
            tools: Vec::new(),
            actions: Vec::new(),
            spent: Spent::default(),
            predicted: None,
            imagined: None,
        })
    }

    /// The next action, if there is a plan for it and there was one for all before.
    fn plan(&mut self, action: u64) -> anyhow::Result<Option<(Arc<ToolShape>, Motion)>> {
        if (self.actions.len() as u64) < action {
            return Ok(None);
        }
        let Self { bench, entry, world, .. } = self;
        let (spec, model) = (bench.spec, entry.contender.model.as_ref());
        // A scene that the model imagined is not one that the simulator was in: it has no snapshot.
        let known = self.imagined.is_none();
        let seen = match self.imagined.take() {
            Some(particles) => particles,
            None => {
                let mut rng = stream(entry.seed, &[PERCEIVING, action]);
                bench.perception.perceive(&Observation::Particles(world.particles()), self.start.len(), &mut rng)?
            }
        };
        let scene = |tool: &Arc<ToolShape>, poses: &[Pose]| {
            let truth = world.scene(tool, poses);
            let snapshot = truth.snapshot.clone().filter(|_| known);
            Scene { particles: seen.clone(), constants: Arc::clone(&bench.constants), snapshot, ..truth }
        };
        let piece = Workpiece::around(&seen);
        if !known && !accepts(bench, model, &scene) {
            // A model that cannot go on from what it imagined has no plan for the whole.
            self.predicted = None;
            return Ok(None);
        }
        let choice = bench.chooser.choose(&Task {
            model,
            tools: &bench.tools,
            scene: &scene,
            piece,
            cost: &self.cost,
            current: &seen.positions,
            goal: &entry.goal.1.points,
            policies: &entry.contender.policies,
            steps: spec.dataset.steps,
            planner: entry.planner.1,
            budget: spec.budget,
            clock: bench.clock,
            seed: entry.seed,
            action,
        })?;
        self.spent += choice.spent();
        let Some((name, plan, motion)) = choice.best() else { return Ok(None) };
        let shape = bench.tools[name].shape();
        if spec.control == ControlSpec::Open {
            let end = model.rollout(&scene(shape, &motion.start), &motion.controls).pop();
            self.imagined = end.map(|end| Particles::at_rest(end.positions));
        }
        self.predicted = Some(plan.cost);
        self.tools.push(name.to_owned());
        self.actions.push(plan.theta.clone());
        Ok(Some((shape.clone(), motion.clone())))
    }

    fn result(&self) -> Attempt {
        let Self { bench, entry, predicted, spent, .. } = self;
        let (contender, (goal_name, goal)) = (entry.contender, entry.goal);
        let end = self.world.particles();
        let value = |particles: &Particles| self.cost.at(0, 0, particles);
        // Without a plan nothing was achieved, which is not the same as having left the shape as it was.
        let measure = |m: &&dyn Metric| {
            let value = m.evaluate(&end.positions, &goal.points, goal.matching);
            (m.name().to_owned(), value.filter(|v| predicted.is_some() && v.is_finite()))
        };
        let row = Row {
            model: contender.name.clone(),
            planner: entry.planner.0.to_owned(),
            goal: goal_name.to_owned(),
            seed: entry.seed,
            control: bench.spec.control,
            predicted: *predicted,
            achieved: predicted.map(|_| value(&end)),
            start: value(&self.start),
            one_step: contender.held_out.as_ref().map(|e| e.one_step),
            rollout: contender.held_out.as_ref().map(|e| e.rollout),
            metrics: METRICS.iter().map(measure).collect(),
            floors: goal.floors.clone(),
            rollouts: spent.rollouts,
            gradients: spent.gradients,
            not_finite: spent.not_finite,
            seconds: spent.seconds,
            commit: bench.commit.to_owned(),
            fingerprint: bench.fingerprint.clone(),
            tools: self.tools.clone(),
            actions: self.actions.clone(),
        };
        let start = self.start.positions.clone();
        Attempt { row, start, goal: goal.points.clone(), achieved: end.positions }
    }
}

/// Whether `model` can plan from this scene with every tool.
fn accepts(bench: &Bench<'_>, model: &dyn WorldModel, scene: &dyn Fn(&Arc<ToolShape>, &[Pose]) -> Scene) -> bool {
    let standing = |shape: &Arc<ToolShape>| scene(shape, &vec![Pose::default(); shape.parts.len()]);
    bench.tools.values().all(|tool| model.accepts(&standing(tool.shape())).is_ok())
}
