//! Goals: the shapes that plans aim at. None comes from a model that plans.
use crate::data::DatasetSpec;
use crate::metric::{METRICS, Matching, sampling_floor};
use crate::perception::{Observation, Perception, PerceptionSpec};
use crate::shape::{FillSpec, Filled, Shape, ShapeSpec, read_points};
use crate::state::stream;
use crate::tool::{Tool, ToolSpec, Workpiece};
use crate::world::World;
use anyhow::Context;
use glam::DVec3;
use indexmap::IndexMap;
use rand::Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// A goal's points and how they relate to the particles that start.
#[derive(Clone, Debug)]
pub struct Goal {
    /// Points of the goal shape \[m\].
    pub points: Vec<DVec3>,
    /// Whether row i is where particle i should go.
    pub matching: Matching,
    /// Every metric between two samplings of the shape, by name; null where it needs correspondence.
    pub floors: IndexMap<String, Option<f64>>,
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
    /// The goal for this start; its points may depend on the start and the seed, never on a model.
    ///
    /// # Errors
    /// A file that cannot be read, a hidden action that the world cannot execute.
    fn make(&self, source: &Source<'_>) -> anyhow::Result<Goal>;
}

family! {
    /// Every kind of goal that a config can name.
    GoalSpec builds Box<dyn GoalMaker> { Simulated(SimulatedSpec), Shape(ShapeGoalSpec), Cloud(CloudSpec) }
}

/// What the world itself makes of this start with one hidden action: reachable, and matched particle by particle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SimulatedSpec {
    /// The tool of the hidden action.
    pub tool: ToolSpec,
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

struct Simulated {
    tool: Box<dyn Tool>,
    action: Vec<[f64; 2]>,
}

impl SimulatedSpec {
    fn build(self) -> anyhow::Result<Simulated> {
        let inside = |[low, high]: &[f64; 2]| 0.0 <= *low && low <= high && *high <= 1.0;
        anyhow::ensure!(
            self.action.iter().all(inside),
            "goal.action must hold pairs [low, high] with 0 ≤ low ≤ high ≤ 1"
        );
        Ok(Simulated { tool: self.tool.build()?, action: self.action })
    }
}

impl GoalMaker for Simulated {
    fn make(&self, source: &Source<'_>) -> anyhow::Result<Goal> {
        let mut world = source.start.clone();
        let piece = Workpiece::around(&world.particles());
        let space = self.tool.space(&piece);
        anyhow::ensure!(
            self.action.len() == space.dimension(),
            "goal.action has {} pairs, but its tool takes {}: {}",
            self.action.len(),
            space.dimension(),
            space.names.join(", ")
        );
        let mut rng = stream(source.seed, &[HIDDEN]);
        let unit: Vec<f64> = self.action.iter().map(|[low, high]| low + (high - low) * rng.random::<f64>()).collect();
        let motion = self.tool.motion(&space.at(&unit), &piece, source.dataset.steps);
        let end = world.execute(self.tool.shape(), &motion).pop().context("an action has at least one step")?;
        let floors = floors(&Filled::under(&world.all_positions(), &FILL)?, end.len(), source.seed);
        Ok(Goal { points: end.positions, matching: Matching::Matched, floors })
    }
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
        let floors = floors(self.0.as_ref(), start.len(), source.seed);
        Ok(Goal { points: points.into_iter().map(|p| p + centre).collect(), matching: Matching::Unmatched, floors })
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
        Ok(Goal { floors: floors(&region, count, source.seed), points, matching: Matching::Unmatched })
    }
}

/// First words of the streams that goals draw from.
const HIDDEN: u64 = u64::from_le_bytes(*b"hidden  ");
const SAMPLES: u64 = u64::from_le_bytes(*b"samples ");

/// How the volume of simulated dough is read off its particles.
const FILL: FillSpec = FillSpec { cell: 0.005, closing: 0.01, opening: 0.0 };

/// Every metric between two samplings of `shape` by `count` points.
fn floors(shape: &dyn Shape, count: usize, seed: u64) -> IndexMap<String, Option<f64>> {
    let sampling = |k| shape.points(count, &mut stream(seed, &[SAMPLES, k]));
    let (first, second) = (sampling(1), sampling(2));
    METRICS.iter().map(|m| (m.name().to_owned(), sampling_floor(*m, &first, &second))).collect()
}
