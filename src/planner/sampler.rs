//! Planners that draw samples and move a distribution: one loop for all of them.
use super::best::Best;
use super::{Objective, Plan, Planner};
use rand_chacha::ChaCha8Rng;

/// What tells one sampling planner from another. Samples are fractions of the box: `0` its low end, `1` its high end.
pub trait Sampler: Send + Sync {
    /// Parameters of the distribution.
    type Params;
    /// The distribution to begin with, over `dimension` coordinates; its samples must not depend on any cost.
    fn init(&self, dimension: usize) -> Self::Params;
    /// Draws the samples of a round, counted from 0; they are moved into the box before they are costed.
    fn sample(&self, params: &Self::Params, round: usize, rng: &mut ChaCha8Rng) -> Vec<Vec<f64>>;
    /// Moves the distribution toward cheap samples; a cost is a finite number or `∞`.
    fn update(&self, params: Self::Params, samples: &[Vec<f64>], costs: &[f64]) -> Self::Params;
    /// Whether to stop, given the least cost seen by the end of each round so far.
    fn done(&self, least: &[f64]) -> bool;
}

impl<S: Sampler> Planner for S {
    fn plan(&self, objective: &dyn Objective, rng: &mut ChaCha8Rng) -> Option<Plan> {
        let mut best = Best::default();
        search(self, self.init(objective.space().dimension()), objective, &mut best, rng);
        best.into_plan()
    }
}

/// Draws from `params` on until the sampler is done or the budget is gone.
pub(super) fn search<S: Sampler>(
    sampler: &S,
    mut params: S::Params,
    objective: &dyn Objective,
    best: &mut Best,
    rng: &mut ChaCha8Rng,
) {
    let mut least = Vec::new();
    while !sampler.done(&least) && !objective.exhausted() {
        let mut samples = sampler.sample(&params, least.len(), rng);
        let costs = best.shoot(objective, &mut samples);
        least.push(best.cost());
        params = sampler.update(params, &samples, &costs);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::state::{ActionSpace, stream};
    use std::sync::atomic::{AtomicUsize, Ordering};

    /// Draws far outside the box, and checks what it is told.
    struct Wild;

    impl Sampler for Wild {
        type Params = usize;
        fn init(&self, dimension: usize) -> usize {
            assert_eq!(dimension, 1);
            0
        }
        fn sample(&self, params: &usize, round: usize, _: &mut ChaCha8Rng) -> Vec<Vec<f64>> {
            assert_eq!(*params, round);
            vec![vec![-3.0], vec![0.25], vec![7.0]]
        }
        fn update(&self, params: usize, samples: &[Vec<f64>], costs: &[f64]) -> usize {
            assert_eq!(samples, [[0.0], [0.25], [1.0]]);
            assert_eq!(costs, [f64::INFINITY, 2.5, 4.0]);
            params + 1
        }
        fn done(&self, least: &[f64]) -> bool {
            assert!(least.iter().all(|cost| *cost == 2.5));
            false
        }
    }

    struct Line {
        space: ActionSpace,
        calls: AtomicUsize,
    }

    impl Objective for Line {
        fn space(&self) -> &ActionSpace {
            &self.space
        }
        fn costs(&self, plans: &[Vec<f64>]) -> Vec<f64> {
            self.calls.fetch_add(1, Ordering::Relaxed);
            plans.iter().map(|p| if p[0] == 2.0 { -f64::NAN } else { p[0] }).collect()
        }
        fn gradient(&self, _: &[f64]) -> Option<(f64, Vec<f64>)> {
            None
        }
        fn exhausted(&self) -> bool {
            self.calls.load(Ordering::Relaxed) == 3
        }
    }

    #[test]
    fn samplers_see_samples_inside_the_box_and_costs_that_order_until_the_budget_ends() {
        let space = ActionSpace { names: vec!["x".into()], low: vec![2.0], high: vec![4.0] };
        let line = Line { space, calls: AtomicUsize::new(0) };
        let plan = Wild.plan(&line, &mut stream(1, &[1])).unwrap();
        assert_eq!((plan, line.calls.into_inner()), (Plan { theta: vec![2.5], cost: 2.5 }, 3));
    }
}
