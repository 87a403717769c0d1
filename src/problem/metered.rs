//! Counts what a planner spends, and stops it when the budget is gone.
use crate::planner::Objective;
use crate::state::ActionSpace;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::{Mutex, MutexGuard};

/// What one search may spend; the same for every model and planner of a comparison.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Budget {
    /// Rollouts of the model, gradients included at their price.
    #[schemars(range(min = 1))]
    pub rollouts: usize,
    /// Rollouts that one gradient costs.
    #[schemars(range(min = 1))]
    pub gradient_price: usize,
    /// Time after which no further rollout begins, if time is limited too \[s\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0))]
    pub seconds: Option<f64>,
}

/// Seconds since any fixed instant \[s\].
pub type Clock<'a> = &'a (dyn Fn() -> f64 + Sync);

/// What a search has spent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Spent {
    /// Rollouts of one action, without gradients; a plan of several actions is as many.
    pub rollouts: usize,
    /// Gradients, likewise.
    pub gradients: usize,
    /// Rollouts and gradients whose cost or slope was not a finite number.
    pub not_finite: usize,
    /// Time since the search began \[s\].
    pub seconds: f64,
}

impl std::ops::AddAssign for Spent {
    fn add_assign(&mut self, other: Self) {
        self.rollouts += other.rollouts;
        self.gradients += other.gradients;
        self.not_finite += other.not_finite;
        self.seconds += other.seconds;
    }
}

/// An objective that answers until its budget is spent: then costs are `∞`, and there is no gradient.
///
/// Plans are served in order, so that for want of rollouts the same plans are refused whatever the thread count. Where seconds are
/// limited, the clock is looked at before each slice of as many plans as there are threads, costs and gradients alike: a slice may
/// outlast the limit by its own duration.
pub struct Metered<'a> {
    inner: &'a dyn Objective,
    budget: Budget,
    clock: Clock<'a>,
    began: f64,
    spent: Mutex<Spent>,
}

impl<'a> Metered<'a> {
    /// Wraps `inner`; time runs from now.
    pub fn new(inner: &'a dyn Objective, budget: Budget, clock: Clock<'a>) -> Self {
        Self { inner, budget, clock, began: clock(), spent: Mutex::default() }
    }

    /// What was spent so far.
    pub fn spent(&self) -> Spent {
        Spent { seconds: self.elapsed(), ..*self.tally() }
    }

    /// Rollouts and gradients whose cost or slope was not a finite number.
    pub fn not_finite(&self) -> usize {
        self.tally().not_finite
    }

    fn tally(&self) -> MutexGuard<'_, Spent> {
        self.spent.lock().expect("nothing panics while it counts")
    }

    fn elapsed(&self) -> f64 {
        (self.clock)() - self.began
    }

    /// Rollouts that may still be spent after those of `spent`.
    fn left(&self, spent: &Spent) -> usize {
        if self.budget.seconds.is_some_and(|limit| self.elapsed() >= limit) {
            return 0;
        }
        self.budget.rollouts.saturating_sub(spent.rollouts + spent.gradients * self.budget.gradient_price)
    }

    /// How many of `wanted` calls at `price` rollouts each the budget still holds; they are booked by `book` at once.
    fn reserve(&self, wanted: usize, price: usize, book: impl FnOnce(&mut Spent, usize)) -> usize {
        let mut spent = self.tally();
        let served = wanted.min(self.left(&spent) / price.max(1));
        book(&mut spent, served);
        served
    }
}

impl Metered<'_> {
    /// How many of `wanted` plans begin without a look at the clock: as many as run at once, or all where time is not limited.
    fn slice(&self, wanted: usize) -> usize {
        if self.budget.seconds.is_some() { rayon::current_num_threads() } else { wanted.max(1) }
    }

    /// Costs of those plans that the budget holds now, `∞` of the others.
    fn served(&self, plans: &[Vec<f64>]) -> Vec<f64> {
        let price = self.inner.price();
        let served = self.reserve(plans.len(), price, |spent, count| spent.rollouts += price * count);
        let mut costs = self.inner.costs(&plans[..served]);
        let broken = costs.iter_mut().filter(|cost| !cost.is_finite()).map(|cost| *cost = f64::INFINITY).count();
        self.tally().not_finite += broken;
        costs.resize(plans.len(), f64::INFINITY);
        costs
    }

    /// Costs and gradients of those plans that the budget holds now, `None` for the others.
    fn served_gradients(&self, plans: &[Vec<f64>]) -> Vec<Option<(f64, Vec<f64>)>> {
        let price = self.inner.price();
        let both = price * self.budget.gradient_price;
        let served = self.reserve(plans.len(), both, |spent, count| spent.gradients += price * count);
        let mut answers = self.inner.gradients(&plans[..served]);
        let mut spent = self.tally();
        for answer in &mut answers {
            match answer {
                Some((cost, slope)) => {
                    spent.not_finite += usize::from(!cost.is_finite() || !slope.iter().all(|s| s.is_finite()));
                    *cost = if cost.is_finite() { *cost } else { f64::INFINITY };
                }
                // A model that has no gradient has spent nothing on it.
                None => spent.gradients -= price,
            }
        }
        answers.resize(plans.len(), None);
        answers
    }
}

impl Objective for Metered<'_> {
    fn space(&self) -> &ActionSpace {
        self.inner.space()
    }

    fn costs(&self, plans: &[Vec<f64>]) -> Vec<f64> {
        plans.chunks(self.slice(plans.len())).flat_map(|plans| self.served(plans)).collect()
    }

    fn gradient(&self, plan: &[f64]) -> Option<(f64, Vec<f64>)> {
        self.gradients(&[plan.to_vec()]).pop()?
    }

    fn gradients(&self, plans: &[Vec<f64>]) -> Vec<Option<(f64, Vec<f64>)>> {
        plans.chunks(self.slice(plans.len())).flat_map(|plans| self.served_gradients(plans)).collect()
    }

    fn price(&self) -> usize {
        self.inner.price()
    }

    fn proposals(&self, most: usize) -> Vec<Vec<f64>> {
        self.inner.proposals(most)
    }

    fn exhausted(&self) -> bool {
        self.left(&self.tally()) < self.inner.price()
    }
}
