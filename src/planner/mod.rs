//! Planners: they see a box and a cost, never a particle.
use crate::state::ActionSpace;
use rand_chacha::ChaCha8Rng;

mod around;
mod best;
mod cem;
mod covariance;
mod covo;
mod descent;
mod grid;
mod lbfgs;
mod mppi;
mod policy;
mod random;
mod refine;
mod sampler;
mod starts;
mod temperature;

pub use around::{Around, AroundSpec};
pub use cem::{Cem, CemSpec};
pub use covariance::{Covariance, FloorSpec};
pub use covo::{Covo, CovoSpec};
pub use descent::{Descent, DescentSpec};
pub use grid::{Grid, GridSpec};
pub use lbfgs::{Lbfgs, LbfgsSpec};
pub use mppi::{Mppi, MppiSpec};
pub use policy::{Policy, PolicySpec};
pub use random::{Random, RandomSpec};
pub use refine::{Refine, RefineSpec};
pub use sampler::Sampler;
pub use temperature::TemperatureSpec;

/// What a planner minimises.
pub trait Objective: Sync {
    /// The box that plans live in.
    fn space(&self) -> &ActionSpace;
    /// Costs of many plans at once; `∞` where a rollout was not finite, or where the budget is spent.
    fn costs(&self, plans: &[Vec<f64>]) -> Vec<f64>;
    /// Cost and gradient, or `None` when there is no gradient or no budget.
    fn gradient(&self, plan: &[f64]) -> Option<(f64, Vec<f64>)>;

    /// Costs and gradients of many plans at once, each as [`Objective::gradient`] gives it.
    fn gradients(&self, plans: &[Vec<f64>]) -> Vec<Option<(f64, Vec<f64>)>> {
        plans.iter().map(|plan| self.gradient(plan)).collect()
    }

    /// Rollouts of one action that the cost of one plan takes.
    fn price(&self) -> usize {
        1
    }

    /// At most `most` plans that something learned thinks good, the best first; none where nothing has learned any.
    fn proposals(&self, _most: usize) -> Vec<Vec<f64>> {
        Vec::new()
    }

    /// Whether no further plan will be costed, so that the planner must return the best it has.
    fn exhausted(&self) -> bool {
        false
    }
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

    /// Whether it has no plan without [`Objective::gradient`].
    fn wants_gradients(&self) -> bool {
        false
    }

    /// Whether it asks for [`Objective::proposals`], which somebody then has to have learned.
    fn wants_proposals(&self) -> bool {
        false
    }
}

family! {
    /// Every planner that a config can name.
    PlannerSpec builds Box<dyn Planner> {
        Random(RandomSpec),
        Grid(GridSpec),
        Cem(CemSpec),
        Mppi(MppiSpec),
        Covo(CovoSpec),
        Descent(DescentSpec),
        Lbfgs(LbfgsSpec),
        Refine(RefineSpec),
        Policy(PolicySpec),
        Around(AroundSpec),
    }
}

/// The plan at fractions `unit` of the box, inside it to the last bit.
fn within(space: &ActionSpace, unit: &[f64]) -> Vec<f64> {
    let mut theta = space.at(unit);
    space.clamp(&mut theta);
    theta
}
