//! Planning through a smooth model whose derivatives are known: problem, budget, planners and tool choice together.
use glam::{DQuat, DVec3};
use indexmap::IndexMap;
use pliant::chooser::{ChooserSpec, ExhaustiveSpec, Task};
use pliant::metric::{CostSpec, GoalCost};
use pliant::model::{Adjoint, Dynamics, WorldModel};
use pliant::planner::{Objective, PlannerSpec};
use pliant::problem::{Budget, Metered, Problem};
use pliant::state::*;
use pliant::tool::{Motion, Tool, Workpiece};
use rand::Rng;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

const WIDTH: f64 = 0.02;
/// The bump's middle in the tool's frame: away from its origin, so that turning moves it.
const TIP: DVec3 = DVec3::new(0.01, 0.0, 0.0);

/// Particles are carried along by a Gaussian bump around the tool's tip: `x' = x + exp(−|x − c|²/2σ²) (c' − c)`.
struct Drag;

#[derive(Clone)]
struct Dragged {
    positions: Vec<DVec3>,
    pose: Pose,
}

fn tip_pull(pose: &Pose, at_tip: DVec3) -> [f64; 6] {
    let turn = (pose.rotation * TIP).cross(at_tip);
    [at_tip.x, at_tip.y, at_tip.z, turn.x, turn.y, turn.z]
}

fn pose_grad(flat: &[f64]) -> PoseGrad {
    PoseGrad { translation: DVec3::from_slice(flat), rotation: DVec3::from_slice(&flat[3..]) }
}

impl Dynamics for Drag {
    type State = Dragged;

    fn accepts(&self, scene: &Scene) -> anyhow::Result<()> {
        anyhow::ensure!(scene.poses.len() == 1, "a drag has one part");
        Ok(())
    }
    fn encode(&self, scene: &Scene) -> Dragged {
        Dragged { positions: scene.particles.positions.clone(), pose: scene.poses[0] }
    }
    fn step(&self, state: &Dragged, control: &Control) -> Dragged {
        let (from, to) = (state.pose.apply(TIP), control.poses[0].apply(TIP));
        let carry = |x: &DVec3| *x + (-x.distance_squared(from) / (2.0 * WIDTH * WIDTH)).exp() * (to - from);
        Dragged { positions: state.positions.iter().map(carry).collect(), pose: control.poses[0] }
    }
    fn decode(&self, state: &Dragged) -> Particles {
        Particles::at_rest(state.positions.clone())
    }
    fn adjoint(&self) -> Option<&dyn Adjoint<Dragged>> {
        Some(self)
    }
}

impl Adjoint<Dragged> for Drag {
    fn step_vjp(&self, state: &Dragged, control: &Control, next: &[f64], _: &mut [f32]) -> (Vec<f64>, ControlGrad) {
        let (from, to) = (state.pose.apply(TIP), control.poses[0].apply(TIP));
        let (mut back, mut at_from, mut at_to) = (Vec::new(), DVec3::ZERO, DVec3::ZERO);
        for (x, pull) in state.positions.iter().zip(next.chunks(3)) {
            let (away, pull) = (*x - from, DVec3::from_slice(pull));
            let bump = (-away.length_squared() / (2.0 * WIDTH * WIDTH)).exp();
            let by_place = pull.dot(to - from) * -bump / (WIDTH * WIDTH) * away;
            back.extend((pull + by_place).to_array());
            at_from -= by_place + bump * pull;
            at_to += bump * pull;
        }
        back.extend(tip_pull(&state.pose, at_from));
        let mut control_grad = pose_grad(&tip_pull(&control.poses[0], at_to));
        let carried = pose_grad(&next[next.len() - 6..]);
        control_grad.translation += carried.translation;
        control_grad.rotation += carried.rotation;
        (back, ControlGrad { poses: vec![control_grad] })
    }
    fn decode_vjp(&self, _: &Dragged, particles: &ParticlesGrad) -> Vec<f64> {
        particles.positions.iter().flat_map(|p| p.to_array()).chain([0.0; 6]).collect()
    }
    fn encode_vjp(&self, start: &Dragged, at_start: &[f64]) -> SceneGrad {
        let (places, pose) = at_start.split_at(3 * start.positions.len());
        let mut particles = ParticlesGrad::zero(start.positions.len());
        particles.positions.iter_mut().zip(places.chunks(3)).for_each(|(p, g)| *p = DVec3::from_slice(g));
        SceneGrad { particles, poses: vec![pose_grad(pose)] }
    }
}

/// The same motion without derivatives, and not finite where the tool starts at x < 0.
struct Broken;

impl Dynamics for Broken {
    type State = Dragged;
    fn encode(&self, scene: &Scene) -> Dragged {
        let mut state = Drag.encode(scene);
        if state.pose.translation.x < 0.0 {
            state.positions[0].x = f64::NAN;
        }
        state
    }
    fn step(&self, state: &Dragged, control: &Control) -> Dragged {
        Drag.step(state, control)
    }
    fn decode(&self, state: &Dragged) -> Particles {
        Drag.decode(state)
    }
}

/// Starts at (x, y), turned by an angle, and slides `length` along its own x axis while it turns a little.
struct Slide {
    shape: Arc<ToolShape>,
    length: f64,
}

fn slide(length: f64) -> Slide {
    let solid = Solid::Cuboid { half: DVec3::splat(0.01) };
    Slide { shape: Arc::new(ToolShape { parts: vec![Part { solid, surface: Vec::new() }] }), length }
}

impl Tool for Slide {
    fn shape(&self) -> &Arc<ToolShape> {
        &self.shape
    }
    fn space(&self, piece: &Workpiece) -> ActionSpace {
        let names = ["x", "y", "rotation"].map(String::from).to_vec();
        let DVec3 { x, y, .. } = piece.extent;
        ActionSpace { names, low: vec![-x, -y, -3.0], high: vec![x, y, 3.0] }
    }
    fn motion(&self, theta: &[f64], piece: &Workpiece, steps: usize) -> Motion {
        let pose = |t: usize| {
            let s = t as f64 / steps as f64;
            let along = DVec3::new(theta[2].cos(), theta[2].sin(), 0.0);
            Pose {
                translation: piece.centre + DVec3::new(theta[0], theta[1], 0.005) + s * self.length * along,
                rotation: DQuat::from_rotation_z(theta[2] + 0.5 * s),
            }
        };
        let controls = (1..=steps).map(|t| Control { poses: vec![pose(t)] }).collect();
        Motion { start: vec![pose(0)], controls }
    }
}

fn cloud() -> Vec<DVec3> {
    let mut rng = stream(1, &[1]);
    (0..50)
        .map(|_| 0.06 * DVec3::new(rng.random::<f64>() - 0.5, rng.random::<f64>() - 0.5, rng.random::<f64>() / 6.0))
        .collect()
}

fn scene(shape: &Arc<ToolShape>, poses: &[Pose]) -> Scene {
    let particles = Particles::at_rest(cloud());
    Scene { particles, tool: shape.clone(), poses: poses.to_vec(), interval: 0.1, snapshot: None }
}

fn piece() -> Workpiece {
    Workpiece::around(&Particles::at_rest(cloud()))
}

/// The shape that a slide of `length` at `theta` leaves: reachable, but not by what planners try first.
fn goal(length: f64, theta: &[f64]) -> Vec<DVec3> {
    let tool = slide(length);
    let motion = tool.motion(theta, &piece(), 6);
    Drag.rollout(&scene(tool.shape(), &motion.start), &motion.controls).pop().unwrap().positions
}

fn cost(kind: &str, goal: Vec<DVec3>) -> GoalCost {
    let text =
        if kind == "weighted" { "kind = 'weighted'\nchamfer = 0.5\nemd = 0.5" } else { &format!("kind = '{kind}'") };
    let spec: CostSpec = toml_edit::de::from_str(text).unwrap();
    GoalCost::new(spec.build().unwrap(), goal).unwrap()
}

fn planner(stem: &str) -> Box<dyn pliant::planner::Planner> {
    let path = format!("{}/configs/planner/{stem}.toml", env!("CARGO_MANIFEST_DIR"));
    let spec: PlannerSpec = toml_edit::de::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    spec.build().unwrap()
}

const BUDGET: Budget = Budget { rollouts: 400, gradient_price: 3, seconds: None };

fn problem<'a>(model: &'a dyn WorldModel, tool: &'a Slide, cost: &'a GoalCost) -> Problem<'a> {
    Problem::new(model, tool, scene(tool.shape(), &[Pose::default()]), piece(), cost, 6).unwrap()
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
            use pliant::model::Cost;
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
}

#[test]
fn a_problem_that_cannot_be_posed_is_refused_with_a_sentence() {
    let (tool, cost) = (slide(0.03), cost("chamfer", cloud()));
    let pose =
        |poses: &[Pose], piece, steps| Problem::new(&Drag, &tool, scene(tool.shape(), poses), piece, &cost, steps);
    assert!(pose(&[Pose::default()], piece(), 0).is_err());
    assert!(format!("{:#}", pose(&[], piece(), 6).err().unwrap()).contains("one part"));
    let nowhere = Workpiece::around(&Particles::default());
    assert!(pose(&[Pose::default()], nowhere, 6).err().unwrap().to_string().contains("action x"));
}

#[test]
fn the_tool_that_made_the_goal_is_chosen_and_every_model_is_offered_the_same_samples() {
    let tools: IndexMap<String, Box<dyn Tool>> = [("short", 0.005), ("right", 0.03), ("twin", 0.03), ("long", 0.12)]
        .map(|(name, length)| (name.to_owned(), Box::new(slide(length)) as Box<dyn Tool>))
        .into();
    let cost = cost("chamfer", goal(0.03, &[0.01, -0.01, 1.0]));
    let chooser = ChooserSpec::Exhaustive(ExhaustiveSpec {}).build().unwrap();
    let cem = planner("cem");
    let choose = |model: &dyn WorldModel, planner: &dyn pliant::planner::Planner, budget, action| {
        let task = Task {
            model,
            tools: &tools,
            scene: &scene,
            piece: piece(),
            cost: &cost,
            steps: 6,
            planner,
            budget,
            clock: &|| 0.0,
            seed: 3,
            action,
        };
        chooser.choose(&task).unwrap()
    };
    let choice = choose(&Drag, cem.as_ref(), BUDGET, 0);
    let (name, plan, motion) = choice.best().unwrap();
    assert!(name == "right" || name == "twin", "{name}");
    assert_eq!(*motion, tools[name].motion(&plan.theta, &piece(), 6));
    let predicted: Vec<f64> = choice.alternatives.iter().map(|a| a.found.as_ref().unwrap().0.cost).collect();
    assert!(predicted.iter().all(|c| *c >= plan.cost));
    assert_eq!(
        choice.alternatives.iter().map(|a| a.tool.as_str()).collect::<Vec<_>>(),
        ["short", "right", "twin", "long"]
    );
    assert_eq!(choice.spent().rollouts, choice.alternatives.iter().map(|a| a.spent.rollouts).sum::<usize>());
    assert_eq!(choice, choose(&Drag, cem.as_ref(), BUDGET, 0));
    assert_ne!(choice, choose(&Drag, cem.as_ref(), BUDGET, 1), "every action of an episode has its own stream");

    // With a budget of one plan, the middle of the box, tools of equal shape tie and the first of them wins.
    let one = choose(&Drag, cem.as_ref(), Budget { rollouts: 1, ..BUDGET }, 0);
    let costs: Vec<f64> = one.alternatives.iter().map(|a| a.found.as_ref().unwrap().0.cost).collect();
    assert_eq!(costs[1], costs[2]);
    assert_ne!(one.chosen, Some(2));
    let none = choose(&Broken, planner("descent").as_ref(), BUDGET, 0);
    assert!(none.best().is_none() && none.spent().gradients == 0);

    let recorded = |model: &dyn WorldModel| {
        let seen = Recorder { model, starts: Default::default() };
        choose(&seen, cem.as_ref(), BUDGET, 0);
        seen.starts.into_inner().unwrap()
    };
    let (first, second) = (recorded(&Drag), recorded(&Broken));
    // The first batch of each tool comes before any cost is known.
    assert_eq!(first[0], second[0]);
    let batch = |list: &[Vec<Motion>]| list.iter().filter(|b| b.len() == 40).cloned().collect::<Vec<_>>();
    assert_eq!(batch(&first), batch(&second));
    assert_eq!(batch(&first).len(), 4);
}

/// Notes what a model is asked.
struct Recorder<'a> {
    model: &'a dyn WorldModel,
    starts: std::sync::Mutex<Vec<Vec<Motion>>>,
}

impl WorldModel for Recorder<'_> {
    fn accepts(&self, scene: &Scene) -> anyhow::Result<()> {
        self.model.accepts(scene)
    }
    fn rollout(&self, scene: &Scene, controls: &[Control]) -> Rollout {
        self.model.rollout(scene, controls)
    }
    fn rollouts(&self, scene: &Scene, motions: &[Motion]) -> Vec<Rollout> {
        self.starts.lock().unwrap().push(motions.to_vec());
        self.model.rollouts(scene, motions)
    }
    fn gradient(&self, _: &Scene, _: &[Control], _: &dyn pliant::model::Cost) -> Option<pliant::model::Gradient> {
        None
    }
    fn weight_gradient(
        &self,
        _: &Scene,
        _: &[Control],
        _: &dyn pliant::model::Cost,
    ) -> Option<pliant::model::Gradient> {
        None
    }
    fn weights(&self) -> Vec<f32> {
        Vec::new()
    }
    fn set_weights(&mut self, _: &[f32]) {}
}
