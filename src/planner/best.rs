//! The best plan seen so far.
use super::Plan;

/// Keeps the cheapest of the plans it is shown; of equals the first, and none whose cost is not finite.
#[derive(Default)]
pub(super) struct Best(Option<Plan>);

impl Best {
    pub(super) fn see(&mut self, theta: &[f64], cost: f64) {
        if cost.is_finite() && cost < self.cost() {
            self.0 = Some(Plan { theta: theta.to_vec(), cost });
        }
    }

    /// Its cost; `∞` before any finite one.
    pub(super) fn cost(&self) -> f64 {
        self.0.as_ref().map_or(f64::INFINITY, |plan| plan.cost)
    }

    pub(super) fn into_plan(self) -> Option<Plan> {
        self.0
    }
}
