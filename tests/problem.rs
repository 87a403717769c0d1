//! Planning through a smooth model whose derivatives are known: problem, budget and planners together.
mod drag;

use drag::*;
use pliant::metric::GoalCost;
use pliant::model::{Cost, WorldModel};
use pliant::planner::Objective;
use pliant::problem::{Budget, Metered, Problem};
use pliant::state::*;
use pliant::tool::{Tool, Workpiece};
use rand::Rng;
use std::sync::atomic::{AtomicU64, Ordering};

fn problem<'a>(model: &'a dyn WorldModel, tool: &'a Slide, cost: &'a GoalCost) -> Problem<'a> {
    Problem::new(model, tool, scene(tool.shape(), &[Pose::default()]), piece(), cost, 6).unwrap()
}

#[test]
fn by_a_share_samplers_plan_and_what_follows_gradients_has_no_plan() {
    let (tool, goal) = (slide(0.03), goal(0.03, &[0.01, -0.01, 2.0]));
    let shared = cost("iou", goal.clone());
    let problem = problem(&Drag, &tool, &shared);
    assert!(problem.gradient(&problem.space().at(&[0.5; 3])).is_none());
    let plan = |stem: &str| planner(stem).plan(&Metered::new(&problem, BUDGET, &|| 0.0), &mut stream(1, &[]));
    for stem in ["descent", "lbfgs", "refine"] {
        assert!(planner(stem).wants_gradients() && plan(stem).is_none(), "{stem}");
    }
    let found = plan("cem").expect("a sampler needs no gradient");
    let still = problem.costs(&[problem.space().at(&[0.5; 3])])[0];
    assert!(found.cost < 0.5 * still, "{} against {still} in the middle of the box", found.cost);
    assert!(!planner("cem").wants_gradients());
}

#[test]
fn the_gradient_of_the_cost_agrees_with_central_differences_in_theta() {
    for kind in ["chamfer", "emd", "weighted"] {
        let (tool, cost) = (slide(0.03), cost(kind, goal(0.03, &[0.01, -0.01, 2.0])));
        let problem = problem(&Drag, &tool, &cost);
        for unit in [[0.5, 0.5, 0.5], [0.3, 0.7, 0.2], [0.6, 0.2, 0.9]] {
            let theta = problem.space().at(&unit);
            let (value, gradient) = problem.gradient(&theta).unwrap();
            assert_eq!(problem.costs(std::slice::from_ref(&theta)), [value]);
            for axis in 0..3 {
                let h = 1e-6 * (problem.space().high[axis] - problem.space().low[axis]);
                let nudged = [h, -h].map(|h| {
                    let mut theta = theta.clone();
                    theta[axis] += h;
                    theta
                });
                let costs = problem.costs(&nudged);
                let expected = (costs[0] - costs[1]) / (2.0 * h);
                let scale = gradient.iter().fold(0.0f64, |m, g| m.max(g.abs()));
                let error = (gradient[axis] - expected).abs() / scale;
                assert!(error < 1e-5, "{kind} {unit:?} {axis}: {} against {expected}", gradient[axis]);
            }
        }
    }
}

#[test]
fn every_candidate_starts_where_its_own_motion_starts() {
    let (tool, cost) = (slide(0.03), cost("chamfer", goal(0.03, &[0.01, -0.01, 2.0])));
    let problem = problem(&Drag, &tool, &cost);
    let mut rng = stream(2, &[1]);
    let unit = |rng: &mut rand_chacha::ChaCha8Rng| [rng.random::<f64>(), rng.random(), rng.random()];
    let plans: Vec<_> = (0..150).map(|_| problem.space().at(&unit(&mut rng))).collect();
    let alone: Vec<f64> = plans
        .iter()
        .map(|theta| {
            let motion = problem.motion(theta);
            cost.total(&Drag.rollout(&scene(tool.shape(), &motion.start), &motion.controls))
        })
        .collect();
    assert_eq!(problem.costs(&plans), alone);
}

#[test]
fn both_planners_find_most_of_a_reachable_goal_within_one_budget() {
    let (tool, cost) = (slide(0.03), cost("chamfer", goal(0.03, &[0.01, -0.01, 1.0])));
    let problem = problem(&Drag, &tool, &cost);
    let middle = problem.costs(&[problem.space().at(&[0.5; 3])])[0];
    for stem in ["cem", "descent"] {
        let metered = Metered::new(&problem, BUDGET, &|| 0.0);
        let plan = planner(stem).plan(&metered, &mut stream(1, &[7])).unwrap();
        assert!(plan.cost < 0.2 * middle, "{stem}: {} from {middle}", plan.cost);
        assert_eq!(problem.costs(std::slice::from_ref(&plan.theta)), [plan.cost], "{stem}");
        let spent = metered.spent();
        assert!(spent.rollouts + 3 * spent.gradients <= 400, "{stem}: {spent:?}");
    }
}

#[test]
fn a_rollout_that_is_not_finite_costs_infinity_and_is_counted() {
    let (tool, cost) = (slide(0.03), cost("chamfer", goal(0.03, &[0.01, -0.01, 1.0])));
    let problem = problem(&Broken, &tool, &cost);
    let metered = Metered::new(&problem, BUDGET, &|| 0.0);
    let (left, right) = (vec![-0.02, 0.0, 0.0], vec![0.02, 0.0, 0.0]);
    let costs = metered.costs(&[left, right.clone()]);
    assert!(costs[0] == f64::INFINITY && costs[1].is_finite());
    assert_eq!((metered.not_finite(), metered.spent().rollouts), (1, 2));
    assert_eq!(metered.gradient(&right), None);
    assert_eq!(metered.spent().gradients, 0, "a model without an adjoint spends nothing");
    let plan = planner("cem").plan(&metered, &mut stream(1, &[7])).unwrap();
    assert!(plan.cost.is_finite() && piece().centre.x + plan.theta[0] >= 0.0);
    assert_eq!(planner("descent").plan(&problem, &mut stream(1, &[7])), None);
}

#[test]
fn time_ends_a_search_too() {
    let (tool, cost) = (slide(0.03), cost("chamfer", goal(0.03, &[0.01, -0.01, 1.0])));
    let problem = problem(&Drag, &tool, &cost);
    let ticks = AtomicU64::new(0);
    let clock = || ticks.fetch_add(1, Ordering::Relaxed) as f64;
    let metered = Metered::new(&problem, Budget { seconds: Some(6.0), ..BUDGET }, &clock);
    assert!(planner("cem").plan(&metered, &mut stream(1, &[7])).is_some());
    let spent = metered.spent();
    assert!(spent.rollouts > 0 && spent.rollouts < 100 && spent.seconds >= 6.0, "{spent:?}");
    assert_eq!(metered.costs(&[vec![0.0; 3]]), [f64::INFINITY]);
    assert_eq!(metered.gradient(&[0.0; 3]), None);

    let metered = Metered::new(&problem, Budget { rollouts: 1000, seconds: Some(6.0), ..BUDGET }, &clock);
    let costs = metered.costs(&vec![vec![0.0; 3]; 1000]);
    let served = costs.iter().filter(|cost| cost.is_finite()).count();
    assert!(
        served == metered.spent().rollouts && (1..500).contains(&served),
        "one long call outlasts nothing: {served}"
    );
}

#[test]
fn a_problem_that_cannot_be_posed_is_refused_with_a_sentence() {
    let (tool, cost) = (slide(0.03), cost("chamfer", goal(0.03, &[0.0; 3])));
    let pose =
        |poses: &[Pose], piece, steps| Problem::new(&Drag, &tool, scene(tool.shape(), poses), piece, &cost, steps);
    assert!(pose(&[Pose::default()], piece(), 0).is_err());
    assert!(format!("{:#}", pose(&[], piece(), 6).err().unwrap()).contains("one part"));
    let nowhere = Workpiece::around(&Particles::default());
    assert!(pose(&[Pose::default()], nowhere, 6).err().unwrap().to_string().contains("action x"));
}
