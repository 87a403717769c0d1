//! Several actions in a row as one plan: what they cost, their gradients, and what looking ahead is good for.
#[path = "../drag/mod.rs"]
mod drag;
mod gate;
mod simulator;

use drag::*;
use glam::DVec3;
use pliant::metric::GoalCost;
use pliant::model::{Cost, WorldModel};
use pliant::planner::Objective;
use pliant::problem::{Budget, Metered, Problem, Sequence};
use pliant::state::*;
use pliant::tool::{Tool, Workpiece};

fn sequence<'a>(model: &'a dyn WorldModel, tools: &[&'a dyn Tool], cost: &'a dyn Cost) -> Sequence<'a> {
    let scene = scene(tools[0].shape(), &[Pose::default()]);
    Sequence::new(model, tools.to_vec(), scene, piece(), cost, 6).unwrap()
}

const UNITS: [[f64; 9]; 3] = [
    [0.5, 0.4, 0.5, 0.6, 0.3, 0.45, 0.5, 0.7, 0.6],
    [0.3, 0.7, 0.2, 0.4, 0.6, 0.9, 0.35, 0.5, 0.1],
    [0.6, 0.2, 0.9, 0.5, 0.5, 0.3, 0.6, 0.4, 0.7],
];

#[test]
fn a_sequence_of_one_is_the_plain_problem_bit_for_bit() {
    let (tool, cost) = (slide(0.03), cost("chamfer", goal(0.03, &[0.01, -0.01, 2.0])));
    let plain = Problem::new(&Drag, &tool, scene(tool.shape(), &[Pose::default()]), piece(), &cost, 6).unwrap();
    let alone = sequence(&Drag, &[&tool], &cost);
    assert_eq!((plain.space(), plain.price()), (alone.space(), alone.price()));
    let plans: Vec<_> = UNITS.iter().map(|unit| plain.space().at(&unit[..3])).collect();
    assert_eq!(plain.costs(&plans), alone.costs(&plans));
    assert_eq!(plain.gradients(&plans), alone.gradients(&plans));
    let strokes = alone.strokes(&plans[0]).unwrap();
    assert_eq!((strokes.len(), &strokes[0].motion), (1, &plain.motion(&plans[0])));
}

/// Costs every state, so that none may be counted twice or left out.
struct Everywhere(GoalCost);

impl Cost for Everywhere {
    fn at(&self, t: usize, horizon: usize, particles: &Particles) -> f64 {
        (1.0 + t as f64) * self.0.at(horizon, horizon, particles)
    }
    fn gradient(&self, t: usize, horizon: usize, particles: &Particles) -> ParticlesGrad {
        let mut gradient = self.0.gradient(horizon, horizon, particles);
        gradient.positions.iter_mut().for_each(|g| *g *= 1.0 + t as f64);
        gradient
    }
}

#[test]
fn the_cost_is_that_of_all_states_one_action_after_the_other() {
    let (long, short) = (slide(0.03), slide(0.015));
    let cost = Everywhere(cost("chamfer", goal(0.03, &[0.01, -0.01, 2.0])));
    let tools: [&dyn Tool; 3] = [&long, &short, &long];
    let problem = sequence(&Drag, &tools, &cost);
    for unit in UNITS {
        let plan = problem.space().at(&unit);
        let mut states = vec![scene(long.shape(), &[Pose::default()]).particles];
        for (k, tool) in tools.iter().enumerate() {
            let particles = states.last().unwrap().clone();
            let piece = Workpiece::around(&particles);
            let theta = tool.space(&piece).at(&unit[3 * k..3 * k + 3]);
            let motion = tool.motion(&theta, &piece, 6);
            let scene = Scene { particles, ..scene(tool.shape(), &motion.start) };
            states.extend(Drag.rollout(&scene, &motion.controls).into_iter().skip(1));
            let stroke = &problem.strokes(&plan).unwrap()[k];
            assert!(stroke.theta.iter().zip(&theta).all(|(a, b)| (a - b).abs() < 1e-12));
            assert!(stroke.start.iter().zip(&scene.particles.positions).all(|(a, b)| a.distance(*b) < 1e-12));
        }
        assert_eq!(states.len(), 19);
        let expected = cost.total(&states);
        assert!((problem.costs(&[plan])[0] / expected - 1.0).abs() < 1e-12);
    }
}

#[test]
fn the_gradient_of_a_sequence_agrees_with_central_differences() {
    let (long, short) = (slide(0.03), slide(0.015));
    let at_the_end = cost("chamfer", goal(0.03, &[0.01, -0.01, 2.0]));
    let all_the_way = Everywhere(cost("chamfer", goal(0.03, &[0.01, -0.01, 2.0])));
    let costs: [&dyn Cost; 2] = [&at_the_end, &all_the_way];
    for cost in costs {
        let problem = sequence(&Drag, &[&long, &short, &long], cost);
        for unit in UNITS {
            let plan = problem.space().at(&unit);
            let (value, gradient) = problem.gradient(&plan).unwrap();
            assert!((value / problem.costs(std::slice::from_ref(&plan))[0] - 1.0).abs() < 1e-12);
            let scale: Vec<f64> = problem.space().by_unit(&gradient).iter().map(|g| g.abs()).collect();
            assert!(scale.chunks(3).all(|part| part.iter().any(|g| *g > 1e-5)), "an action without a say: {scale:?}");
            for axis in 0..9 {
                let h = 1e-6 * (problem.space().high[axis] - problem.space().low[axis]);
                let nudged = [h, -h].map(|h| {
                    let mut plan = plan.clone();
                    plan[axis] += h;
                    plan
                });
                let costs = problem.costs(&nudged);
                let width = problem.space().high[axis] - problem.space().low[axis];
                let (found, expected) = (gradient[axis] * width, (costs[0] - costs[1]) / (2.0 * h) * width);
                let most = scale.iter().fold(0.0f64, |m, g| m.max(*g));
                assert!((found - expected).abs() < 2e-5 * most, "{unit:?} {axis}: {found} against {expected}");
            }
        }
    }
}

#[test]
fn a_plan_of_three_actions_costs_three_rollouts() {
    let (tool, cost) = (slide(0.03), cost("chamfer", goal(0.03, &[0.01, -0.01, 2.0])));
    let problem = sequence(&Drag, &[&tool, &tool, &tool], &cost);
    let metered = Metered::new(&problem, Budget { rollouts: 20, gradient_price: 2, seconds: None }, &|| 0.0);
    let plans = vec![problem.space().at(&UNITS[0]); 4];
    assert!(metered.costs(&plans).iter().all(|cost| cost.is_finite()));
    assert_eq!(metered.spent().rollouts, 12);
    let slopes = metered.gradients(&plans);
    assert_eq!(slopes.iter().filter(|slope| slope.is_some()).count(), 1, "6 of the 8 that are left");
    assert_eq!((metered.spent().gradients, metered.exhausted()), (3, true));
    assert_eq!(metered.costs(&plans[..1]), [f64::INFINITY]);
}

#[test]
fn what_breaks_between_two_actions_costs_infinity_and_the_others_keep_their_cost() {
    let (tool, cost) = (slide(0.03), cost("chamfer", goal(0.03, &[0.01, -0.01, 1.0])));
    let problem = sequence(&Broken, &[&tool, &tool], &cost);
    let away = [0.9, 0.5, 0.5, 0.9, 0.5, 0.5];
    let (good, mut first, mut second) = (away, away, away);
    (first[0], second[3]) = (0.1, 0.1);
    let plans = [first, good, second].map(|unit| problem.space().at(&unit));
    let costs = problem.costs(&plans);
    assert!(costs[0] == f64::INFINITY && costs[2] == f64::INFINITY && costs[1].is_finite(), "{costs:?}");
    assert_eq!(costs[1], problem.costs(&plans[1..2])[0]);
    assert!(problem.strokes(&plans[0]).is_none() && problem.strokes(&plans[1]).is_some());
    assert!(scene(tool.shape(), &[]).particles.positions.iter().any(|p: &DVec3| p.x < 0.0));
}
