//! One attempt: a model, a planner, a goal and a seed, from the first observation to the last action.
use super::{Bench, Contender, ControlSpec, Goal, Row};
use crate::chooser::Task;
use crate::metric::{GoalCost, METRICS, Metric};
use crate::model::{Cost, WorldModel};
use crate::perception::Observation;
use crate::planner::Planner;
use crate::problem::Spent;
use crate::state::{Particles, Pose, Scene, ToolShape, stream};
use crate::tool::Workpiece;
use crate::world::World;
use glam::DVec3;
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
pub(super) fn attempt(bench: &Bench<'_>, entry: &Entry<'_>) -> anyhow::Result<Attempt> {
    let spec = bench.spec;
    let (goal_name, goal) = entry.goal;
    let model = entry.contender.model.as_ref();
    let cost = GoalCost::new(spec.cost.clone().build()?, goal.points.clone())?;
    let mut world = entry.start.clone();
    let start = world.particles();
    let (mut tools, mut actions, mut spent, mut predicted) = (Vec::new(), Vec::new(), Spent::default(), None);
    let mut imagined: Option<Particles> = None;
    for action in 0..spec.actions as u64 {
        // A scene that the model imagined is not one that the simulator was in: it has no snapshot.
        let known = imagined.is_none();
        let seen = match imagined.take() {
            Some(particles) => particles,
            None => {
                let mut rng = stream(entry.seed, &[PERCEIVING, action]);
                bench.perception.perceive(&Observation::Particles(world.particles()), start.len(), &mut rng)?
            }
        };
        let scene = |tool: &Arc<ToolShape>, poses: &[Pose]| {
            let truth = world.scene(tool, poses);
            Scene { particles: seen.clone(), snapshot: truth.snapshot.clone().filter(|_| known), ..truth }
        };
        let piece = Workpiece::around(&seen);
        if !known && !accepts(bench, model, &scene) {
            // A model that cannot go on from what it imagined has no plan for the whole.
            predicted = None;
            break;
        }
        let choice = bench.chooser.choose(&Task {
            model,
            tools: &bench.tools,
            scene: &scene,
            piece,
            cost: &cost,
            steps: spec.dataset.steps,
            planner: entry.planner.1,
            budget: spec.budget,
            clock: bench.clock,
            seed: entry.seed,
            action,
        })?;
        spent += choice.spent();
        let Some((name, plan, motion)) = choice.best() else { break };
        let shape = bench.tools[name].shape();
        if spec.control == ControlSpec::Open {
            let end = model.rollout(&scene(shape, &motion.start), &motion.controls).pop();
            imagined = end.map(|end| Particles::at_rest(end.positions));
        }
        world.execute(shape, motion);
        predicted = Some(plan.cost);
        tools.push(name.to_owned());
        actions.push(plan.theta.clone());
    }
    let end = world.particles();
    let value = |particles: &Particles| cost.at(0, 0, particles);
    // Without a plan nothing was achieved, which is not the same as having left the shape as it was.
    let planned = predicted.is_some();
    let measure = |m: &&dyn Metric| {
        let value = m.evaluate(&end.positions, &goal.points, goal.matching);
        (m.name().to_owned(), value.filter(|v| planned && v.is_finite()))
    };
    let row = Row {
        model: entry.contender.name.clone(),
        planner: entry.planner.0.to_owned(),
        goal: goal_name.to_owned(),
        seed: entry.seed,
        control: spec.control,
        predicted,
        achieved: predicted.map(|_| value(&end)),
        start: value(&start),
        one_step: entry.contender.held_out.as_ref().map(|e| e.one_step),
        rollout: entry.contender.held_out.as_ref().map(|e| e.rollout),
        metrics: METRICS.iter().map(measure).collect(),
        floors: goal.floors.clone(),
        rollouts: spent.rollouts,
        gradients: spent.gradients,
        not_finite: spent.not_finite,
        seconds: spent.seconds,
        commit: bench.commit.to_owned(),
        fingerprint: bench.fingerprint.clone(),
        tools,
        actions,
    };
    Ok(Attempt { row, start: start.positions, goal: goal.points.clone(), achieved: end.positions })
}

/// Whether `model` can plan from this scene with every tool.
fn accepts(bench: &Bench<'_>, model: &dyn WorldModel, scene: &dyn Fn(&Arc<ToolShape>, &[Pose]) -> Scene) -> bool {
    let standing = |shape: &Arc<ToolShape>| scene(shape, &vec![Pose::default(); shape.parts.len()]);
    bench.tools.values().all(|tool| model.accepts(&standing(tool.shape())).is_ok())
}
