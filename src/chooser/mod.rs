//! Which tool to use next.
use crate::model::{Cost, WorldModel};
use crate::planner::{Plan, Planner};
use crate::problem::{Budget, Clock, Metered, Problem, Spent};
use crate::state::{Pose, Scene, ToolShape, stream};
use crate::tool::{Motion, Tool, Workpiece};
use crate::train::policy::Policy;
use anyhow::Context;
use glam::DVec3;
use indexmap::IndexMap;
use std::path::Path;
use std::sync::Arc;

mod classifier;
mod exhaustive;
mod fixed;
mod lesson;
mod random;

pub use classifier::{ClassifierSpec, Likely};
pub use exhaustive::{Exhaustive, ExhaustiveSpec};
pub use fixed::{Fixed, FixedSpec};
pub use lesson::{ChooserMaker, Lesson};
pub use random::{Random, RandomSpec};

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
}

/// What the search of one tool found.
#[derive(Clone, Debug, PartialEq)]
pub struct Alternative {
    /// The tool's name.
    pub tool: String,
    /// Its best plan and the path of that plan; `None` when the planner found none.
    pub found: Option<(Plan, Motion)>,
    /// What the search cost.
    pub spent: Spent,
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

    /// Plans every tool of the shortlist and takes the best.
    ///
    /// # Errors
    /// When a tool's problem cannot be posed, naming the tool.
    fn choose(&self, task: &Task<'_>) -> anyhow::Result<Choice> {
        let began = (task.clock)();
        let shortlist = self.shortlist(task);
        let shortlisting = (task.clock)() - began;
        let alternatives = shortlist.into_iter().map(|i| task.plan(i)).collect::<anyhow::Result<Vec<_>>>()?;
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
        Classifier(ClassifierSpec),
        Random(RandomSpec),
        Fixed(FixedSpec),
    }
}

impl Task<'_> {
    /// Searches the actions of the tool at `place` with a random stream of (seed, action, place): never of the model, so that
    /// every model is offered the same samples.
    ///
    /// # Errors
    /// When the tool's problem cannot be posed, naming the tool.
    fn plan(&self, place: usize) -> anyhow::Result<Alternative> {
        let (name, tool) = self.tools.get_index(place).context("the chooser shortlists a tool that is not there")?;
        let space = tool.space(&self.piece);
        let start = tool.motion(&space.at(&vec![0.5; space.dimension()]), &self.piece, self.steps).start;
        let scene = (self.scene)(tool.shape(), &start);
        let problem = Problem::new(self.model, tool.as_ref(), scene, self.piece, self.cost, self.steps)
            .with_context(|| format!("tool {name} cannot be planned"))?;
        let problem = match self.policies.get(name) {
            Some(policy) => problem.advised(policy, self.goal),
            None => problem,
        };
        let metered = Metered::new(&problem, self.budget, self.clock);
        let plan = self.planner.plan(&metered, &mut stream(self.seed, &[PLANNING, self.action, place as u64]));
        let spent = metered.spent();
        let found = plan.map(|plan| {
            let motion = problem.motion(&plan.theta);
            (plan, motion)
        });
        Ok(Alternative { tool: name.clone(), found, spent })
    }
}
