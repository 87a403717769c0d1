//! An attempt under way.
use super::attempt::Entry;
use super::{Attempt, Bench, ControlSpec, Row};
use crate::chooser::{Next, Task};
use crate::metric::{Column, GoalCost, Metric};
use crate::model::{Cost, WorldModel};
use crate::perception::Observation;
use crate::problem::Spent;
use crate::state::{Particles, Pose, Rollout, Scene, Snapshot, ToolShape, stream};
use crate::tool::{Motion, Workpiece};
use crate::world::World;
use std::collections::VecDeque;
use std::sync::Arc;

/// First words of the streams that perception and disturbances draw from.
const PERCEIVING: u64 = u64::from_le_bytes(*b"perceive");
const DISTURBING: u64 = u64::from_le_bytes(*b"disturb ");

/// The world as it has become, and what was planned and spent on the way.
pub(super) struct Run<'a> {
    bench: &'a Bench<'a>,
    pub(super) entry: &'a Entry<'a>,
    cost: GoalCost,
    world: World,
    start: Particles,
    tools: Vec<String>,
    actions: Vec<Vec<f64>>,
    spent: Spent,
    plans: usize,
    /// What the last plan promised; none as long as there was none.
    predicted: Option<f64>,
    /// What that plan foresees next.
    pending: VecDeque<Next>,
    /// Where the model thinks that the last action ends, in open loop.
    imagined: Option<Seen>,
}

/// A state to plan from.
struct Seen {
    particles: Particles,
    /// The simulator's own, where a model carries it on; of the world itself it is taken when it is needed.
    snapshot: Option<Snapshot>,
}

/// An action to execute.
pub(super) struct Act {
    /// The tool's name.
    pub(super) tool: String,
    pub(super) theta: Vec<f64>,
    pub(super) shape: Arc<ToolShape>,
    pub(super) motion: Motion,
}

impl<'a> Run<'a> {
    pub(super) fn new(bench: &'a Bench<'a>, entry: &'a Entry<'a>) -> anyhow::Result<Self> {
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
            plans: 0,
            predicted: None,
            pending: VecDeque::new(),
            imagined: None,
        })
    }

    /// The next action, if there is a plan for it, there was one for all before, and the goal is not reached.
    pub(super) fn plan(&mut self, action: u64) -> anyhow::Result<Option<Act>> {
        if (self.actions.len() as u64) < action {
            return Ok(None);
        }
        let known = self.imagined.is_none();
        let seen = match self.imagined.take() {
            Some(imagined) => imagined,
            None => Seen { particles: self.observe(action)?, snapshot: None },
        };
        if self.bench.spec.until.is_some_and(|least| self.cost.at(0, 0, &seen.particles) <= least) {
            return Ok(None);
        }
        let kept =
            self.pending.pop_front().filter(|next| self.bench.spec.control.keeps(&next.stroke.start, &seen.particles));
        let act = match kept {
            Some(Next { tool, stroke }) => {
                let shape = self.bench.tools[&tool].shape().clone();
                Some(Act { tool, theta: stroke.theta, shape, motion: stroke.motion })
            }
            None => self.search(action, &seen, known)?,
        };
        let Some(act) = act else { return Ok(None) };
        self.tools.push(act.tool.clone());
        self.actions.push(act.theta.clone());
        Ok(Some(act))
    }

    fn observe(&self, action: u64) -> anyhow::Result<Particles> {
        let mut rng = stream(self.entry.seed, &[PERCEIVING, action]);
        let observation = Observation::Particles(self.world.particles());
        self.bench.perception.perceive(&observation, self.start.len(), &mut rng)
    }

    /// The first action of a new plan from what is `seen`, which is `known` or else imagined.
    fn search(&mut self, action: u64, seen: &Seen, known: bool) -> anyhow::Result<Option<Act>> {
        let Self { bench, entry, world, .. } = self;
        let (spec, model) = (bench.spec, entry.contender.model.as_ref());
        let scene = |tool: &Arc<ToolShape>, poses: &[Pose]| {
            let truth = world.scene(tool, poses);
            // A scene that the model imagined is not one that the simulator was in.
            let snapshot = if known { truth.snapshot.clone() } else { seen.snapshot.clone() };
            Scene { particles: seen.particles.clone(), constants: Arc::clone(&bench.constants), snapshot, ..truth }
        };
        self.pending.clear();
        if !known && !accepts(bench, model, &scene) {
            // A model that cannot go on from what it imagined, such as what is no number, has no plan for the whole.
            self.predicted = None;
            return Ok(None);
        }
        let choice = bench.chooser.choose(&Task {
            model,
            tools: &bench.tools,
            scene: &scene,
            piece: spec.aim.at(action, &seen.particles, world),
            cost: &self.cost,
            current: &seen.particles.positions,
            goal: &entry.goal.1.points,
            policies: &entry.contender.policies,
            steps: spec.dataset.steps,
            planner: entry.planner.1,
            budget: spec.budget,
            clock: bench.clock,
            seed: entry.seed,
            action,
            lookahead: spec.lookahead.min(spec.actions - action as usize),
        })?;
        self.spent += choice.spent();
        self.plans += 1;
        let Some((name, plan, motion)) = choice.best() else { return Ok(None) };
        let shape = bench.tools[name].shape();
        if spec.control == ControlSpec::Open {
            let ends = model.follow(&[scene(shape, &motion.start)], std::slice::from_ref(motion));
            self.imagined = ends.into_iter().next().and_then(|(mut rollout, snapshot)| {
                Some(Seen { particles: Particles::at_rest(rollout.pop()?.positions), snapshot })
            });
        }
        self.predicted = Some(plan.cost);
        self.pending = choice.rest().to_vec().into();
        let (tool, theta) = (name.to_owned(), plan.theta.clone());
        Ok(Some(Act { tool, theta, shape: shape.clone(), motion: motion.clone() }))
    }

    /// Executes an action: the states that it goes through.
    pub(super) fn act(&mut self, act: &Act) -> Rollout {
        self.world.execute(&act.shape, &act.motion)
    }

    /// Lets happen what does between this action and the next one.
    pub(super) fn disturb(&mut self, action: u64) {
        if let Some(disturbance) = &self.bench.disturbance
            && action + 1 < self.bench.spec.actions as u64
        {
            disturbance.disturb(&mut self.world, &mut stream(self.entry.seed, &[DISTURBING, action]));
        }
    }

    /// The cost as things are.
    pub(super) fn cost(&self) -> f64 {
        self.cost.at(0, 0, &self.world.particles())
    }

    /// What the last plan promised.
    pub(super) fn predicted(&self) -> Option<f64> {
        self.predicted
    }

    pub(super) fn spent(&self) -> Spent {
        self.spent
    }

    /// What the action of this number is aimed at as things are.
    pub(super) fn piece(&self, action: u64) -> Workpiece {
        self.bench.spec.aim.at(action, &self.world.particles(), &self.world)
    }

    /// What has come of it.
    pub(super) fn result(&self) -> Attempt {
        let Self { bench, entry, predicted, spent, .. } = self;
        let (contender, (goal_name, goal)) = (entry.contender, entry.goal);
        let end = self.world.particles();
        let value = |particles: &Particles| self.cost.at(0, 0, particles);
        // A search that found no plan achieved nothing, which is not the same as having left the shape as it was. Who never searched
        // was there from the start.
        let counts = predicted.is_some() || self.plans == 0;
        let measure = |(name, metric): (&str, &dyn Metric)| {
            let value = metric.evaluate(&end.positions, &goal.points, goal.matching);
            (name.to_owned(), value.filter(|v| counts && v.is_finite()))
        };
        let row = Row {
            model: contender.name.clone(),
            planner: entry.planner.0.to_owned(),
            goal: goal_name.to_owned(),
            seed: entry.seed,
            control: bench.spec.control,
            predicted: *predicted,
            achieved: counts.then(|| value(&end)),
            start: value(&self.start),
            one_step: contender.held_out.as_ref().map(|e| e.one_step),
            rollout: contender.held_out.as_ref().map(|e| e.rollout),
            metrics: bench.reported().map(measure).collect(),
            columns: bench.metrics.iter().map(|(name, metric)| (name.clone(), Column::of(metric.as_ref()))).collect(),
            floors: entry.floors.clone(),
            rollouts: spent.rollouts,
            gradients: spent.gradients,
            not_finite: spent.not_finite,
            seconds: spent.seconds,
            commit: bench.commit.to_owned(),
            fingerprint: bench.fingerprint.clone(),
            plans: matches!(bench.spec.control, ControlSpec::Triggered { .. }).then_some(self.plans),
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
