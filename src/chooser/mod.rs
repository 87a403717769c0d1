//! Which tool to use next.
use crate::model::{Cost, WorldModel};
use crate::planner::{Objective, Plan, Planner};
use crate::problem::{Budget, Clock, Metered, Problem, Sequence, Spent, Stroke};
use crate::state::{Pose, Scene, ToolShape, stream};
use crate::tool::{Motion, Tool, Workpiece};
use crate::train::policy::Policy;
use anyhow::{Context, ensure};
use glam::DVec3;
use indexmap::IndexMap;
use std::path::Path;
use std::sync::Arc;

mod classifier;
mod exhaustive;
mod fixed;
mod lesson;
mod ordered;
mod random;
mod repeated;

pub use classifier::{ClassifierSpec, Likely};
pub use exhaustive::{Exhaustive, ExhaustiveSpec};
pub use fixed::{Fixed, FixedSpec};
pub use lesson::{ChooserMaker, Lesson};
pub use ordered::{Ordered, OrderedSpec};
pub use random::{Random, RandomSpec};
pub use repeated::{Repeated, RepeatedSpec};

/// First word of every stream that planning draws from.
const PLANNING: u64 = u64::from_le_bytes(*b"planning");

/// One decision to take: which tool, and which of its actions, brings the scene nearest to the goal.
pub struct Task<'a> {
    /// What predicts.
    pub model: &'a dyn WorldModel,
    /// What may be used; their order decides ties and random streams.
    pub tools: &'a IndexMap<String, Box<dyn Tool>>,
    /// The present scene with a tool of this shape at these poses.
    pub scene: &'a dyn Fn(&Arc<ToolShape>, &[Pose]) -> Scene,
    /// The material that the tools are aimed at.
    pub piece: Workpiece,
    /// What is minimised.
    pub cost: &'a dyn Cost,
    /// Points of the material \[m\].
    pub current: &'a [DVec3],
    /// Points of the goal, for those who have learned to look at it \[m\].
    pub goal: &'a [DVec3],
    /// What has learned to propose actions of a tool, by the tool's name.
    pub policies: &'a IndexMap<String, Policy>,
    /// Control steps of one action.
    pub steps: usize,
    /// What searches each tool's actions.
    pub planner: &'a dyn Planner,
    /// What the search of **each** tool may spend.
    pub budget: Budget,
    /// What measures the budget's seconds.
    pub clock: Clock<'a>,
    /// Seed of the whole experiment.
    pub seed: u64,
    /// Number of this action in its episode, from 0.
    pub action: u64,
    /// Actions in a row that one plan describes.
    pub lookahead: usize,
}

/// Most sequences of tools that one decision plans, each with a budget of its own.
const SEQUENCES: usize = 32;

/// What the search of one tool, or of one sequence of tools, found.
#[derive(Clone, Debug, PartialEq)]
pub struct Alternative {
    /// The first tool's name.
    pub tool: String,
    /// θ of the first action of its best plan, the cost of the whole, and the first path; `None` when the planner found none.
    pub found: Option<(Plan, Motion)>,
    /// The actions after the first one.
    pub then: Vec<Next>,
    /// What the search cost.
    pub spent: Spent,
}

/// An action that a plan foresees after others.
#[derive(Clone, Debug, PartialEq)]
pub struct Next {
    /// The tool's name.
    pub tool: String,
    /// What to do with it, and where the particles were predicted to be by then.
    pub stroke: Stroke,
}

/// A decision and what was weighed for it.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// Every tool that was planned, in the order of the task's tools.
    pub alternatives: Vec<Alternative>,
    /// Time that choosing what to plan took \[s\].
    pub shortlisting: f64,
    /// Which of them has the least predicted cost, ties going to the first; `None` when none has a plan.
    pub chosen: Option<usize>,
}

impl Choice {
    /// Name, plan and path of the chosen tool.
    pub fn best(&self) -> Option<(&str, &Plan, &Motion)> {
        let chosen = &self.alternatives[self.chosen?];
        chosen.found.as_ref().map(|(plan, motion)| (chosen.tool.as_str(), plan, motion))
    }

    /// What the chosen plan foresees after its first action.
    pub fn rest(&self) -> &[Next] {
        self.chosen.map_or(&[], |chosen| &self.alternatives[chosen].then)
    }

    /// What the shortlist and all searches cost together.
    pub fn spent(&self) -> Spent {
        let shortlisted = Spent { seconds: self.shortlisting, ..Spent::default() };
        self.alternatives.iter().fold(shortlisted, |mut sum, a| {
            sum += a.spent;
            sum
        })
    }
}

/// Chooses a tool: some are planned, and the best predicted cost wins.
pub trait Chooser: Send + Sync {
    /// Places in `task.tools` of those worth planning, ascending.
    fn shortlist(&self, task: &Task<'_>) -> Vec<usize>;

    /// Folder of what it has learned, where it has learned anything.
    fn folder(&self) -> Option<&Path> {
        None
    }

    /// Sequences of as many tools as the task looks ahead, by their places: every one of the shortlist's.
    ///
    /// # Errors
    /// When they are too many.
    fn sequences(&self, task: &Task<'_>) -> anyhow::Result<Vec<Vec<usize>>> {
        let tools = self.shortlist(task);
        let count = u32::try_from(task.lookahead).ok().and_then(|actions| tools.len().checked_pow(actions));
        ensure!(
            task.lookahead <= 1 || count.is_some_and(|count| count <= SEQUENCES),
            "{} actions of {} tools are more than {SEQUENCES} sequences; look less far ahead, offer fewer tools, or choose chooser.kind \
             \"repeated\" or \"ordered\"",
            task.lookahead,
            tools.len()
        );
        let longer = |sequences: Vec<Vec<usize>>, _| {
            let append = |sequence: &Vec<usize>, tool: &usize| sequence.iter().chain([tool]).copied().collect();
            sequences.iter().flat_map(|sequence| tools.iter().map(move |tool| append(sequence, tool))).collect()
        };
        Ok((0..task.lookahead.max(1)).fold(vec![Vec::new()], longer))
    }

    /// Plans every sequence and takes the best.
    ///
    /// # Errors
    /// When a tool's problem cannot be posed, naming the tool, and as [`Chooser::sequences`].
    fn choose(&self, task: &Task<'_>) -> anyhow::Result<Choice> {
        let began = (task.clock)();
        let sequences = self.sequences(task)?;
        let shortlisting = (task.clock)() - began;
        let alternatives = sequences.iter().map(|places| task.plan(places)).collect::<anyhow::Result<Vec<_>>>()?;
        let cost = |i: usize| alternatives[i].found.as_ref().map(|(plan, _)| plan.cost);
        let planned = (0..alternatives.len()).filter_map(|i| Some((i, cost(i)?)));
        let chosen = planned.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(i, _)| i);
        Ok(Choice { alternatives, shortlisting, chosen })
    }
}

family! {
    /// Every chooser that a config can name.
    ChooserSpec builds Box<dyn ChooserMaker> {
        Exhaustive(ExhaustiveSpec),
        Repeated(RepeatedSpec),
        Ordered(OrderedSpec),
        Classifier(ClassifierSpec),
        Random(RandomSpec),
        Fixed(FixedSpec),
    }
}

impl Task<'_> {
    /// Searches the actions of the tools at `places`, one after the other, with a random stream of (seed, action, places): never of
    /// the model, so that every model is offered the same samples.
    ///
    /// # Errors
    /// When the problem cannot be posed, naming the tools.
    fn plan(&self, places: &[usize]) -> anyhow::Result<Alternative> {
        let at = |place: &usize| self.tools.get_index(*place).context("the chooser lists a tool that is not there");
        let chosen = places.iter().map(at).collect::<anyhow::Result<Vec<_>>>()?;
        let names: Vec<&str> = chosen.iter().map(|(name, _)| name.as_str()).collect();
        let (name, tool) = chosen.first().context("the chooser lists a sequence without a tool")?;
        let space = tool.space(&self.piece);
        let start = tool.motion(&space.at(&vec![0.5; space.dimension()]), &self.piece, self.steps).start;
        let scene = (self.scene)(tool.shape(), &start);
        let sentence = || format!("tool {} cannot be planned", names.join(" then "));
        let purpose: Vec<u64> =
            [PLANNING, self.action].into_iter().chain(places.iter().map(|place| *place as u64)).collect();
        let search = |objective: &dyn Objective| {
            let metered = Metered::new(objective, self.budget, self.clock);
            (self.planner.plan(&metered, &mut stream(self.seed, &purpose)), metered.spent())
        };
        if chosen.len() == 1 {
            let problem = Problem::new(self.model, tool.as_ref(), scene, self.piece, self.cost, self.steps);
            let problem = problem.with_context(sentence)?;
            let problem = match self.policies.get(*name) {
                Some(policy) => problem.advised(policy, self.goal),
                None => problem,
            };
            let (plan, spent) = search(&problem);
            let found = plan.map(|plan| {
                let motion = problem.motion(&plan.theta);
                (plan, motion)
            });
            return Ok(Alternative { tool: (*name).clone(), found, then: Vec::new(), spent });
        }
        let tools = chosen.iter().map(|(_, tool)| tool.as_ref()).collect();
        let problem = Sequence::new(self.model, tools, scene, self.piece, self.cost, self.steps);
        let problem = problem.with_context(sentence)?;
        let (plan, spent) = search(&problem);
        let strokes = plan.and_then(|plan| Some((plan.cost, problem.strokes(&plan.theta)?)));
        let Some((cost, strokes)) = strokes else {
            return Ok(Alternative { tool: (*name).clone(), found: None, then: Vec::new(), spent });
        };
        let mut all = names.iter().zip(strokes);
        let first = all.next().map(|(_, first)| (Plan { theta: first.theta, cost }, first.motion));
        let then = all.map(|(name, stroke)| Next { tool: (*name).to_owned(), stroke }).collect();
        Ok(Alternative { tool: (*name).clone(), found: first, then, spent })
    }
}
