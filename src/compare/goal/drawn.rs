//! What a hidden action of a tool that the seed draws makes of the start.
use super::{Goal, GoalMaker, HIDDEN, Source, execute, inside};
use crate::metric::Matching;
use crate::state::stream;
use anyhow::Context;
use rand::Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What the world itself makes of this start with one hidden action of one of the tools that planners may use, which the seed draws
/// too.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DrawnSpec {
    /// Number of this goal among several of one seed, each with a tool and an action of its own.
    pub number: u64,
    /// Every number of the action, as a fraction \[0, 1\] of the tool's box at this start, is drawn between these two.
    pub action: [f64; 2],
}

/// See [`DrawnSpec`].
pub(crate) struct Drawn(DrawnSpec);

impl DrawnSpec {
    pub(crate) fn build(self) -> anyhow::Result<Drawn> {
        anyhow::ensure!(inside(&self.action), "goal.action must be a pair [low, high] with 0 ≤ low ≤ high ≤ 1");
        Ok(Drawn(self))
    }
}

impl GoalMaker for Drawn {
    fn make(&self, source: &Source<'_>) -> anyhow::Result<Goal> {
        let Self(DrawnSpec { number, action: [low, high] }) = self;
        let mut rng = stream(source.seed, &[HIDDEN, *number]);
        let tools = &source.dataset.tool;
        let (_, tool) = tools.get_index(rng.random_range(0..tools.len())).context("a number below their count")?;
        let tool = tool.clone().build()?;
        let mut world = source.start.clone();
        execute(tool.as_ref(), source.dataset.steps, &mut world, |space| {
            Ok((0..space.dimension()).map(|_| low + (high - low) * rng.random::<f64>()).collect())
        })?;
        Ok(Goal { points: world.particles().positions, matching: Matching::Matched, samplings: None })
    }
}
