//! Goals: the shapes that plans aim at. None comes from a model that is written or fitted; those of hidden actions are what the
//! simulator makes of them, and the simulator is also what plans as `oracle`.
use crate::data::DatasetSpec;
use crate::metric::{Matching, Metric, sampling_floor};
use crate::perception::{Observation, Perception, PerceptionSpec};
use crate::shape::{Shape, ShapeSpec, read_points};
use crate::state::{ActionSpace, stream};
use crate::tool::{Tool, Workpiece};
use crate::world::World;
use anyhow::Context;
use glam::DVec3;
use indexmap::IndexMap;
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

mod drawn;
mod recipe;
mod word;

pub use drawn::DrawnSpec;
pub use recipe::{ActionSpec, RecipeSpec};
pub use word::WordSpec;

/// A goal's points and how they relate to the particles that start.
#[derive(Clone, Debug)]
pub struct Goal {
    /// Points of the goal shape \[m\].
    pub points: Vec<DVec3>,
    /// Whether row i is where particle i should go.
    pub matching: Matching,
    /// Two more samplings of the shape \[m\]; none of a goal that is no sampling: it can be reached.
    pub samplings: Option<[Vec<DVec3>; 2]>,
}

impl Goal {
    /// What each of `metrics` says of two samplings of the shape; nothing of a goal that is no sampling.
    pub fn floors<'m>(
        &self,
        metrics: impl Iterator<Item = (&'m str, &'m dyn Metric)>,
    ) -> IndexMap<String, Option<f64>> {
        let Some([first, second]) = &self.samplings else { return IndexMap::new() };
        metrics.map(|(name, metric)| (name.to_owned(), sampling_floor(metric, first, second))).collect()
    }
}

/// What a goal is drawn from.
pub struct Source<'a> {
    /// The world before the first action.
    pub start: &'a World,
    /// Scene, tools and steps of an action.
    pub dataset: &'a DatasetSpec,
    /// Folder of files that others recorded.
    pub root: &'a std::path::Path,
    /// Seed of the attempt.
    pub seed: u64,
}

/// Makes a goal for one start.
pub trait GoalMaker: Send + Sync {
    /// The goal for this start; its points may depend on the start, the seed and the simulator (`oracle`), on no other model.
    ///
    /// # Errors
    /// A file that cannot be read, a hidden action that the world cannot execute.
    fn make(&self, source: &Source<'_>) -> anyhow::Result<Goal>;
}

family! {
    /// Every kind of goal that a config can name.
    GoalSpec builds Box<dyn GoalMaker> {
        Simulated(SimulatedSpec),
        Drawn(DrawnSpec),
        Shape(ShapeGoalSpec),
        Word(WordSpec),
        Recipe(RecipeSpec),
        Cloud(CloudSpec),
    }
}

/// What the world itself makes of this start with one hidden action of a tool that planners may use too: it can be reached,
/// and is matched particle by particle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SimulatedSpec {
    /// Name of the hidden action's tool, one of the dataset's.
    pub tool: String,
    /// The action as fractions \[0, 1\] of the tool's box at this start, each drawn between the two numbers.
    pub action: Vec<[f64; 2]>,
}

/// A shape standing on the table at the workpiece's centre.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ShapeGoalSpec {
    /// The shape.
    pub shape: ShapeSpec,
}

/// A point cloud that somebody recorded.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CloudSpec {
    /// File, relative to `data.root`.
    pub file: PathBuf,
    /// How particles are read out of the cloud.
    pub perception: PerceptionSpec,
}

struct Simulated(SimulatedSpec);

fn inside([low, high]: &[f64; 2]) -> bool {
    0.0 <= *low && low <= high && *high <= 1.0
}

impl SimulatedSpec {
    fn build(self) -> anyhow::Result<Simulated> {
        anyhow::ensure!(
            self.action.iter().all(inside),
            "goal.action must hold pairs [low, high] with 0 ≤ low ≤ high ≤ 1"
        );
        Ok(Simulated(self))
    }
}

impl GoalMaker for Simulated {
    fn make(&self, source: &Source<'_>) -> anyhow::Result<Goal> {
        let Self(SimulatedSpec { tool, action }) = self;
        let mut world = source.start.clone();
        hidden(tool, action, source, &mut world, &mut stream(source.seed, &[HIDDEN]))?;
        let points = world.particles().positions;
        Ok(Goal { points, matching: Matching::Matched, samplings: None })
    }
}

/// Executes an action of the tool called `name` in `world`, its fractions of the tool's box drawn between the numbers of `action`.
fn hidden(
    name: &str,
    action: &[[f64; 2]],
    source: &Source<'_>,
    world: &mut World,
    rng: &mut ChaCha8Rng,
) -> anyhow::Result<()> {
    let known = &source.dataset.tool;
    let tool = known.get(name).with_context(|| {
        let names = known.keys().map(String::as_str).collect::<Vec<_>>().join(", ");
        format!("goal.tool is \"{name}\", which planners do not have; choose from {names}")
    })?;
    execute(tool.clone().build()?.as_ref(), source.dataset.steps, world, |space| {
        anyhow::ensure!(
            action.len() == space.dimension(),
            "goal.action has {} pairs, but {name} takes {}: {}",
            action.len(),
            space.dimension(),
            space.names.join(", ")
        );
        Ok(action.iter().map(|[low, high]| low + (high - low) * rng.random::<f64>()).collect())
    })
}

/// Executes the action of `tool` that lies at the fractions of its box that `draw` gives.
fn execute(
    tool: &dyn Tool,
    steps: usize,
    world: &mut World,
    draw: impl FnOnce(&ActionSpace) -> anyhow::Result<Vec<f64>>,
) -> anyhow::Result<()> {
    let piece = Workpiece::around(&world.particles());
    let space = tool.space(&piece);
    let unit = draw(&space)?;
    world.execute(tool.shape(), &tool.motion(&space.at(&unit), &piece, steps));
    Ok(())
}

struct ShapeGoal(Box<dyn Shape>);

impl ShapeGoalSpec {
    fn build(self) -> anyhow::Result<ShapeGoal> {
        Ok(ShapeGoal(self.shape.build()?))
    }
}

impl GoalMaker for ShapeGoal {
    fn make(&self, source: &Source<'_>) -> anyhow::Result<Goal> {
        let start = source.start.particles();
        let centre = Workpiece::around(&start).centre;
        let points = self.0.points(start.len(), &mut stream(source.seed, &[SAMPLES]));
        let samplings = samplings(sampled(self.0.as_ref(), start.len(), source.seed));
        Ok(Goal { points: points.into_iter().map(|p| p + centre).collect(), matching: Matching::Unmatched, samplings })
    }
}

struct Cloud {
    file: PathBuf,
    perception: Box<dyn Perception>,
}

impl CloudSpec {
    fn build(self) -> anyhow::Result<Cloud> {
        Ok(Cloud { file: self.file, perception: self.perception.build()? })
    }
}

impl GoalMaker for Cloud {
    fn make(&self, source: &Source<'_>) -> anyhow::Result<Goal> {
        let cloud = Observation::Cloud(read_points(&source.root.join(&self.file))?);
        let region = self.perception.region(&cloud).with_context(|| format!("in {}", self.file.display()))?;
        let count = source.start.particles().len();
        let points = region.points(count, &mut stream(source.seed, &[SAMPLES]));
        Ok(Goal { samplings: samplings(sampled(&region, count, source.seed)), points, matching: Matching::Unmatched })
    }
}

/// First words of the streams that goals draw from.
const HIDDEN: u64 = u64::from_le_bytes(*b"hidden  ");
const SAMPLES: u64 = u64::from_le_bytes(*b"samples ");

/// Samplings 1 and 2 of a shape; the goal is another one.
fn samplings(sampling: impl Fn(u64) -> Vec<DVec3>) -> Option<[Vec<DVec3>; 2]> {
    Some([sampling(1), sampling(2)])
}

/// The samplings of `shape` by `count` points.
fn sampled(shape: &dyn Shape, count: usize, seed: u64) -> impl Fn(u64) -> Vec<DVec3> {
    move |k| shape.points(count, &mut stream(seed, &[SAMPLES, k]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::CompareSpec;
    use crate::config;

    fn goal(change: &str) -> (CompareSpec, World, anyhow::Result<Goal>) {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/configs/compare/quickstart.toml");
        let spec = config::load::<CompareSpec>(path.as_ref(), &[change.to_owned()]).unwrap().spec;
        let start = World::new(&spec.dataset.scene, 3).unwrap();
        let source = Source { start: &start, dataset: &spec.dataset, root: "".as_ref(), seed: 3 };
        let goal = spec.goal["gripped"].clone().build().unwrap().make(&source);
        (spec, start, goal)
    }

    #[test]
    fn a_simulated_goal_is_exactly_what_one_action_of_a_planners_own_box_makes() {
        let (spec, mut world, goal) = goal("goal.gripped.action=[[0.4, 0.4], [0.7, 0.7], [0.2, 0.2]]");
        let tool = spec.dataset.tool["gripper_rod"].clone().build().unwrap();
        let piece = Workpiece::around(&world.particles());
        let space = tool.space(&piece);
        let theta = space.at(&[0.4, 0.7, 0.2]);
        space.check(&theta).unwrap();
        let before = world.particles().positions;
        let end = world.execute(tool.shape(), &tool.motion(&theta, &piece, spec.dataset.steps)).pop().unwrap();
        let goal = goal.unwrap();
        assert_eq!(end.positions, goal.points);
        assert_ne!(before, goal.points);
    }

    #[test]
    fn a_drawn_goal_is_the_seeds_and_its_numbers_alone() {
        let (spec, start, _) = goal("seeds=[3]");
        let made = |number: u64, seed: u64| {
            let source = Source { start: &start, dataset: &spec.dataset, root: "".as_ref(), seed };
            let maker = GoalSpec::Drawn(DrawnSpec { number, action: [0.3, 0.7] }).build().unwrap();
            maker.make(&source).unwrap().points
        };
        assert_eq!(made(0, 3), made(0, 3));
        assert_ne!(made(0, 3), made(1, 3), "every number has an action of its own");
        assert_ne!(made(0, 3), made(0, 4), "every seed has an action of its own");
        assert_ne!(made(0, 3), start.particles().positions);
        assert!(GoalSpec::Drawn(DrawnSpec { number: 0, action: [0.7, 0.3] }).build().is_err());
    }

    #[test]
    fn a_tool_that_planners_do_not_have_makes_no_goal() {
        let sentence = goal("goal.gripped.tool=knife").2.unwrap_err().to_string();
        assert!(sentence.contains("\"knife\"") && sentence.contains("gripper_rod, press_square"), "{sentence}");
    }
}
