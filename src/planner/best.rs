//! The best plan seen so far.
use super::{Objective, Plan, within};

/// Keeps the cheapest of the plans it is shown; of equals the first, and none whose cost is not finite.
#[derive(Default)]
pub(super) struct Best(Option<Plan>);

impl Best {
    pub(super) fn see(&mut self, theta: &[f64], cost: f64) {
        if cost.is_finite() && cost < self.cost() {
            self.0 = Some(Plan { theta: theta.to_vec(), cost });
        }
    }

    /// The costs of `plans`, `∞` where they are not finite; each plan is seen.
    pub(super) fn costs(&mut self, objective: &dyn Objective, plans: &[Vec<f64>]) -> Vec<f64> {
        let finite = |cost: f64| if cost.is_finite() { cost } else { f64::INFINITY };
        let costs: Vec<f64> = objective.costs(plans).into_iter().map(finite).collect();
        plans.iter().zip(&costs).for_each(|(plan, cost)| self.see(plan, *cost));
        costs
    }

    /// The costs of `samples` \[fractions of the box\], which are moved into the box first.
    pub(super) fn shoot(&mut self, objective: &dyn Objective, samples: &mut [Vec<f64>]) -> Vec<f64> {
        samples.iter_mut().flatten().for_each(|u| *u = u.clamp(0.0, 1.0));
        let plans: Vec<_> = samples.iter().map(|u| within(objective.space(), u)).collect();
        self.costs(objective, &plans)
    }

    /// Its cost; `∞` before any finite one.
    pub(super) fn cost(&self) -> f64 {
        self.0.as_ref().map_or(f64::INFINITY, |plan| plan.cost)
    }

    pub(super) fn into_plan(self) -> Option<Plan> {
        self.0
    }
}
