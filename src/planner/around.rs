//! A search, then the cross-entropy method around what it found.
use super::best::Best;
use super::sampler::search;
use super::{Cem, CemSpec, Objective, Plan, Planner, PlannerSpec};
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Config of [`Around`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AroundSpec {
    /// Any planner; what it leaves of the budget is the cross-entropy method's.
    pub search: Box<PlannerSpec>,
    /// The method, whose first round lies around the plan that was found instead of the middle of the box.
    pub cem: CemSpec,
}

/// Runs the search, then the cross-entropy method around its plan; where the search finds none there is none.
pub struct Around {
    search: Box<dyn Planner>,
    cem: Cem,
}

impl AroundSpec {
    pub(crate) fn build(self) -> anyhow::Result<Around> {
        Ok(Around { search: self.search.build()?, cem: self.cem.build()? })
    }
}

impl Planner for Around {
    fn plan(&self, objective: &dyn Objective, rng: &mut ChaCha8Rng) -> Option<Plan> {
        let found = self.search.plan(objective, rng)?;
        let mut best = Best::default();
        best.see(&found.theta, found.cost);
        let first = self.cem.around(objective.space().unit(&found.theta));
        search(&self.cem, first, objective, &mut best, rng);
        best.into_plan()
    }

    fn wants_gradients(&self) -> bool {
        self.search.wants_gradients()
    }

    fn wants_proposals(&self) -> bool {
        self.search.wants_proposals()
    }
}
