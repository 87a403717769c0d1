//! What a policy proposes, costed.
use super::best::Best;
use super::{Objective, Plan, Planner};
use anyhow::ensure;
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Config of [`Policy`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PolicySpec {
    /// Most proposals that are costed, the most probable ones.
    #[schemars(range(min = 1))]
    pub proposals: usize,
}

/// Costs what has been learned to be a good plan, and keeps the cheapest; without anything learned there is no plan.
#[derive(Clone, Debug)]
pub struct Policy {
    proposals: usize,
}

impl PolicySpec {
    pub(crate) fn build(self) -> anyhow::Result<Policy> {
        ensure!(self.proposals >= 1, "planner.proposals must be at least 1");
        Ok(Policy { proposals: self.proposals })
    }
}

impl Planner for Policy {
    fn plan(&self, objective: &dyn Objective, _: &mut ChaCha8Rng) -> Option<Plan> {
        let (mut plans, mut best) = (objective.proposals(self.proposals), Best::default());
        plans.iter_mut().for_each(|theta| objective.space().clamp(theta));
        best.costs(objective, &plans);
        best.into_plan()
    }

    fn wants_proposals(&self) -> bool {
        true
    }
}
