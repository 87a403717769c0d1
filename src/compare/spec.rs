//! Config of a comparison: `configs/compare/*.toml`.
use super::disturbance::DisturbanceSpec;
use super::{AimSpec, ContenderSpec, ControlSpec, GoalSpec};
use crate::chooser::ChooserSpec;
use crate::data::DatasetSpec;
use crate::metric::{CostSpec, METRICS, MetricSpec};
use crate::perception::{Observation, PerceptionSpec};
use crate::planner::{Planner, PlannerSpec};
use crate::problem::Budget;
use crate::shape::{Shape, read_points};
use crate::train::policy::PolicySpec;
use crate::world::{SceneSpec, World};
use anyhow::Context;
use indexmap::IndexMap;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Every model plans with every planner to every goal from every seed; all else is identical.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CompareSpec {
    /// Root of what comparisons share: datasets and fits.
    #[serde(default = "runs")]
    pub artifacts: PathBuf,
    /// Folder of the results; by default one below `artifacts` named by the config's fingerprint.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub out: Option<PathBuf>,
    /// Files that others recorded.
    #[serde(default)]
    pub data: DataSpec,
    /// Scene, tools and episodes that models are fitted to; planning uses the same tools, and the same scene but where there is
    /// another.
    pub dataset: DatasetSpec,
    /// Fit to the first so many of the training episodes only; the held-out ones stay the same.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 3))]
    pub learn_from: Option<usize>,
    /// What is planned in, if that is not the scene that models are fitted to.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scene: Option<SceneSpec>,
    /// Episodes in the scene that is planned in, which the models that `adapt` learn from; none is drawn where it is absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 5))]
    pub interactions: Option<usize>,
    /// Which interactions: another number, other starts and actions.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub interactions_seed: u64,
    /// Where attempts start; by default a start of the scene drawn by the seed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start: Option<StartSpec>,
    /// The contenders, by name.
    pub model: IndexMap<String, ContenderSpec>,
    /// The planners, by name.
    pub planner: IndexMap<String, PlannerSpec>,
    /// The goals, by name.
    pub goal: IndexMap<String, GoalSpec>,
    /// How particles are read out of what is observed.
    pub perception: PerceptionSpec,
    /// What planners minimise.
    pub cost: CostSpec,
    /// Metrics that are reported beside those that always are, by the name of their column.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub metric: IndexMap<String, MetricSpec>,
    /// How the tool is chosen.
    pub chooser: ChooserSpec,
    /// How policies are learned, where a planner asks for their proposals.
    #[serde(default, skip_serializing_if = "PolicySpec::is_default")]
    pub policy: PolicySpec,
    /// What each search may spend; one search a tool and action.
    pub budget: Budget,
    /// Whether the world is observed between actions.
    #[serde(default)]
    pub control: ControlSpec,
    /// Actions in a row.
    #[schemars(range(min = 1))]
    pub actions: usize,
    /// Actions that each plan describes, at most as many as are left; the first is executed, and by `triggered` control the others
    /// too.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    #[schemars(range(min = 1, max = 4))]
    pub lookahead: usize,
    /// Cost at which there is nothing more to do \[m\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0))]
    pub until: Option<f64>,
    /// What of the scene the tools are aimed at.
    #[serde(default, skip_serializing_if = "AimSpec::is_default")]
    pub aim: AimSpec,
    /// What happens to the material between actions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub disturbance: Option<DisturbanceSpec>,
    /// Seeds of starts and random streams.
    #[schemars(length(min = 1))]
    pub seeds: Vec<u64>,
}

/// Where recorded files are.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DataSpec {
    /// Folder that the files named by goals and starts are relative to.
    pub root: PathBuf,
}

/// A start rebuilt from a recorded cloud, the same for every seed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StartSpec {
    /// Point cloud, relative to `data.root`.
    pub file: PathBuf,
    /// How the volume under the cloud is read.
    pub perception: PerceptionSpec,
}

/// Default root of artifacts, below the current folder.
pub const RUNS: &str = "runs";

fn runs() -> PathBuf {
    PathBuf::from(RUNS)
}

fn one() -> usize {
    1
}

fn is_zero(seed: &u64) -> bool {
    *seed == 0
}

fn is_one(count: &usize) -> bool {
    *count == 1
}

impl CompareSpec {
    /// Refuses a comparison of nothing.
    ///
    /// # Errors
    /// A sentence naming the empty list.
    pub(super) fn check(&self) -> anyhow::Result<()> {
        let lists = [
            ("model", self.model.len()),
            ("planner", self.planner.len()),
            ("goal", self.goal.len()),
            ("seeds", self.seeds.len()),
            ("actions", self.actions),
        ];
        let adapts = self.model.iter().find(|(_, model)| !model.adapt.is_empty());
        if let (Some((name, _)), None) = (adapts, self.interactions) {
            anyhow::bail!("model.{name} adapts, but there is nothing to adapt to; set `interactions=12`");
        }
        let empty = lists.iter().find(|(_, count)| *count == 0);
        anyhow::ensure!(empty.is_none(), "`{}` is empty: nothing would be compared", empty.map_or("", |(key, _)| key));
        anyhow::ensure!(
            (1..=4).contains(&self.lookahead),
            "`lookahead` is {}; a plan describes 1 to 4 actions",
            self.lookahead
        );
        anyhow::ensure!(
            self.lookahead == 1 || self.aim == AimSpec::Whole,
            "`aim` is \"pieces\", of which every action works another one: it goes with `lookahead` = 1 alone"
        );
        for (name, metric) in &self.metric {
            anyhow::ensure!(
                METRICS.iter().all(|known| known.name() != name),
                "metric.{name} has the name of a metric that is always reported; give its column another name"
            );
            metric.clone().build().with_context(|| format!("in `metric.{name}`"))?;
        }
        self.check_gradients()?;
        self.check_proposals()?;
        self.control.check(self.lookahead)
    }

    /// Refuses planners that would learn to propose single actions where plans are several.
    fn check_proposals(&self) -> anyhow::Result<()> {
        let Some(name) = self.planner_that(self.lookahead > 1, |planner| planner.wants_proposals())? else {
            return Ok(());
        };
        anyhow::bail!(
            "planner.{name} costs what a policy proposes, which is one action, and `lookahead` is {}: leave that planner out, or set \
             `lookahead=1`",
            self.lookahead
        )
    }

    /// Refuses planners that can have no plan whatever the model.
    fn check_gradients(&self) -> anyhow::Result<()> {
        let flat = !self.cost.clone().build()?.has_gradient();
        let Some(name) = self.planner_that(flat, |planner| planner.wants_gradients())? else { return Ok(()) };
        anyhow::bail!(
            "planner.{name} follows gradients, and `cost` has none: a share changes by steps; leave that planner out, or choose a \
             distance, such as cost={{kind=chamfer}}"
        )
    }

    /// Name of the first planner that wants what is not there, where it is `missing`.
    fn planner_that(&self, missing: bool, wants: fn(&dyn Planner) -> bool) -> anyhow::Result<Option<&str>> {
        for (name, planner) in self.planner.iter().filter(|_| missing) {
            if wants(&*planner.clone().build()?) {
                return Ok(Some(name));
            }
        }
        Ok(None)
    }

    /// The same comparison with every mesh of its tools taken from `data.root`.
    pub(super) fn rooted(&self) -> Self {
        let mut spec = self.clone();
        spec.dataset.tool.values_mut().for_each(|tool| *tool = tool.under(&self.data.root));
        spec
    }

    /// The same, likewise, with the scene that is planned in.
    pub(super) fn planned(&self) -> Self {
        let mut spec = self.rooted();
        spec.dataset.scene = spec.scene.take().unwrap_or(spec.dataset.scene);
        spec
    }
}

impl StartSpec {
    /// A world whose dough fills the volume under the cloud.
    ///
    /// # Errors
    /// A file that cannot be read, a cloud without an object, an object that the scene's lattice cannot fill.
    pub fn rebuild(&self, root: &Path, scene: &SceneSpec) -> anyhow::Result<World> {
        let region =
            self.perception.clone().build()?.region(&Observation::Cloud(read_points(&root.join(&self.file))?))?;
        World::around(scene, &|point| region.contains(point), region.bounds())
    }
}
