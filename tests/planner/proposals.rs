//! Planners that begin with what something has learned to be good.
use crate::field::*;
use pliant::planner::Objective;
use pliant::problem::{Budget, Metered};
use pliant::state::ActionSpace;
use std::sync::Mutex;

/// An objective for which something has been learned; notes the plans that it is asked to cost.
struct Advised<O> {
    inner: O,
    learned: Vec<Vec<f64>>,
    asked: Mutex<Vec<Vec<f64>>>,
}

fn advised<O: Objective>(inner: O, learned: &[&[f64]]) -> Advised<O> {
    Advised { inner, learned: learned.iter().map(|plan| plan.to_vec()).collect(), asked: Mutex::default() }
}

impl<O: Objective> Objective for Advised<O> {
    fn space(&self) -> &ActionSpace {
        self.inner.space()
    }
    fn costs(&self, plans: &[Vec<f64>]) -> Vec<f64> {
        self.asked.lock().unwrap().extend(plans.to_vec());
        self.inner.costs(plans)
    }
    fn gradient(&self, plan: &[f64]) -> Option<(f64, Vec<f64>)> {
        self.inner.gradient(plan)
    }
    fn proposals(&self, most: usize) -> Vec<Vec<f64>> {
        self.learned.iter().take(most).cloned().collect()
    }
}

/// Near the valley's end at (1, 1), the second one nearest; the fifth is better than all of them.
const NEAR: [&[f64]; 5] = [&[0.5, 0.5], &[0.8, 0.7], &[0.0, 0.5], &[-1.0, 1.0], &[1.0, 1.0]];
const WIDE: Budget = Budget { rollouts: 1000, gradient_price: 3, seconds: None };

#[test]
fn the_cheapest_of_the_most_probable_proposals_wins_and_each_costs_one_rollout() {
    let objective = advised(rosenbrock(), &NEAR);
    let metered = Metered::new(&objective, WIDE, &|| 0.0);
    let plan = run(&named("policy", "proposals = 4"), &metered, 1).unwrap();
    assert_eq!(plan.theta, NEAR[1]);
    assert_eq!(metered.spent().rollouts, 4);
    assert_eq!(*objective.asked.lock().unwrap(), NEAR[..4]);
}

#[test]
fn without_proposals_there_is_no_plan_and_nothing_is_spent() {
    for stem in BY_PROPOSAL {
        let objective = rosenbrock();
        let metered = Metered::new(&objective, WIDE, &|| 0.0);
        assert_eq!(run(&named(stem, ""), &metered, 1), None, "{stem}");
        assert_eq!(metered.spent().rollouts, 0, "{stem}");
    }
}

#[test]
fn whoever_begins_with_proposals_says_so() {
    for stem in ALL.into_iter().chain(BY_PROPOSAL) {
        let planner = named(stem, "").build().unwrap();
        assert_eq!(planner.wants_proposals(), BY_PROPOSAL.contains(&stem), "{stem}");
    }
}

#[test]
fn what_is_proposed_outside_the_box_is_moved_into_it_and_what_costs_no_number_never_wins() {
    for stem in BY_PROPOSAL {
        let objective = advised(rosenbrock(), &[&[-7.0, 9.0]]);
        let plan = run(&named(stem, ""), &objective, 1).unwrap();
        assert!(objective.space().contains(&plan.theta), "{stem}: {plan:?}");
        assert_eq!(objective.asked.lock().unwrap()[0], [-2.0, 3.0], "{stem}");
        let never =
            Field { space: space(&[0.0], &[1.0]), value: |_: &[f64]| f64::NAN, slope: None::<fn(&[f64]) -> Vec<f64>> };
        assert_eq!(run(&named(stem, ""), &advised(never, &[&[0.5]]), 1), None, "{stem}");
    }
}

#[test]
fn rounds_around_a_proposal_find_what_it_only_points_to() {
    for seed in 0..5 {
        let plan = |stem: &str| run(&named(stem, ""), &advised(rosenbrock(), &NEAR[..4]), seed).unwrap();
        let (alone, refined) = (plan("policy"), plan("policy_refine"));
        assert_eq!(refined, plan("policy_refine"), "equal seeds give equal plans");
        assert!(refined.cost < alone.cost, "seed {seed}: {refined:?} from {alone:?}");
        let away = refined.theta.iter().zip(&alone.theta).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(away < 0.4 * 4.0, "they stay around it: {refined:?} from {alone:?}");
    }
}

#[test]
fn the_budget_holds_for_proposals_too() {
    for stem in BY_PROPOSAL {
        for rollouts in [0, 1, 3, 4, 7, 20] {
            let objective = advised(rosenbrock(), &NEAR);
            let metered = Metered::new(&objective, Budget { rollouts, ..WIDE }, &|| 0.0);
            let plan = run(&named(stem, ""), &metered, 2);
            assert!(metered.spent().rollouts <= rollouts, "{stem} with {rollouts}");
            assert_eq!(plan.is_some(), rollouts > 0, "{stem} with {rollouts}");
        }
    }
}
