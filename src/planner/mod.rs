//! Planners: they see a box and a cost, never a particle.
use crate::state::ActionSpace;
use rand_chacha::ChaCha8Rng;

/// What a planner minimises.
pub trait Objective: Sync {
    /// The box that plans live in.
    fn space(&self) -> &ActionSpace;
    /// Costs of many plans at once; `∞` where a rollout was not finite, or where the budget is spent.
    fn costs(&self, plans: &[Vec<f64>]) -> Vec<f64>;
    /// Cost and gradient, or `None` when there is no gradient or no budget.
    fn gradient(&self, plan: &[f64]) -> Option<(f64, Vec<f64>)>;
}

/// The best plan a planner found.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// θ, inside the box.
    pub theta: Vec<f64>,
    /// The cost that the model promises for it.
    pub cost: f64,
}

/// A search over a box.
pub trait Planner: Send + Sync {
    /// The best plan found, or `None` when the objective lacks what this planner needs or no plan has a finite cost.
    fn plan(&self, objective: &dyn Objective, rng: &mut ChaCha8Rng) -> Option<Plan>;
}
