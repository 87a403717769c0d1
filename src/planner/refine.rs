//! A search, then a descent from what it found.
use super::best::Best;
use super::{Descent, DescentSpec, Objective, Plan, Planner, PlannerSpec, within};
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Config of [`Refine`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RefineSpec {
    /// Any planner; what it leaves of the budget is the descent's.
    pub search: Box<PlannerSpec>,
    /// The descent; it starts from the search's plan and draws no candidates.
    pub descent: DescentSpec,
}

/// Runs the search, then descends from its plan; without a gradient there is no plan.
pub struct Refine {
    search: Box<dyn Planner>,
    descent: Descent,
}

impl RefineSpec {
    pub(crate) fn build(self) -> anyhow::Result<Refine> {
        Ok(Refine { search: self.search.build()?, descent: self.descent.build()? })
    }
}

impl Planner for Refine {
    fn plan(&self, objective: &dyn Objective, rng: &mut ChaCha8Rng) -> Option<Plan> {
        let (space, mut best) = (objective.space(), Best::default());
        // Asked before any rollout is spent.
        let middle = within(space, &vec![0.5; space.dimension()]);
        best.see(&middle, objective.gradient(&middle)?.0);
        if let Some(found) = self.search.plan(objective, rng) {
            best.see(&found.theta, found.cost);
            self.descent.descend(objective, vec![space.unit(&found.theta)], None, &mut best);
        }
        best.into_plan()
    }

    fn wants_gradients(&self) -> bool {
        true
    }

    fn wants_proposals(&self) -> bool {
        self.search.wants_proposals()
    }
}
