//! Gradients with respect to an action θ, through tool motion, contact and a whole rollout, for every kind of model that plans
//! with one.
use glam::DVec3;
use pliant::compare::CompareSpec;
use pliant::config;
use pliant::metric::{ChamferSpec, CostSpec, GoalCost};
use pliant::model::WorldModel;
use pliant::planner::Objective;
use pliant::problem::Problem;
use pliant::state::{Particles, Scene, stream};
use pliant::tool::Workpiece;
use pliant::world::World;
use rand::Rng;

/// Written, learned, and every hybrid of the two.
const NAMES: [&str; 8] =
    ["analytic", "learned", "hybrid", "residual", "neural_constants", "output_residual", "feature", "projected"];

/// The quickstart with models that see eighty of the particles. With all of them, on a regular lattice, written particles buckle
/// under a grip: a step of 1e-7 of a bound then changes the slope itself, and no difference converges.
fn quickstart() -> CompareSpec {
    let changes = ["particles=80", "start.x=[0.05,0.07]", "start.y=[0.05,0.07]", "start.z=[0.025,0.035]"];
    let mut changes = changes.map(|change| format!("dataset.scene.{change}")).to_vec();
    changes.push(format!("model=[{}]", NAMES.join(",")));
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/configs/compare/quickstart.toml");
    config::load(path.as_ref(), &changes).unwrap().spec
}

/// The contender before it is fitted; weights that start at zero are moved away, or a gradient through them would be trivial.
fn model(spec: &CompareSpec, name: &str) -> Box<dyn WorldModel> {
    let mut model = spec.model[name].dynamics.clone().build().unwrap();
    let mut rng = stream(5, &[1]);
    let weights: Vec<f32> = model.weights().iter().map(|w| w + 0.05 * (rng.random::<f32>() - 0.5)).collect();
    model.set_weights(&weights);
    model
}

/// Reaches of the differences as fractions of each bound's range: rounding (of float32 in the networks) spoils the shortest,
/// curvature and changing contacts the longest; which is best differs by model and tool, so the best of all is judged.
const REACHES: [f64; 6] = [3e-4, 3e-5, 1e-5, 3e-6, 1e-6, 3e-7];

/// J'(0) from the least-squares fit of `a x` to the central differences `(J(x) − J(−x))/2` at x = h/4 … h.
fn slope_of(cost: impl Fn(&[f64]) -> Vec<f64>, h: f64) -> f64 {
    let nudges: Vec<f64> = (1..=4).map(|k| h * f64::from(k) / 4.0).collect();
    let costs = cost(&nudges.iter().flat_map(|x| [*x, -x]).collect::<Vec<_>>());
    let along: f64 = nudges.iter().zip(costs.chunks_exact(2)).map(|(x, pair)| x * (pair[0] - pair[1]) / 2.0).sum();
    along / nudges.iter().map(|x| x * x).sum::<f64>()
}

#[test]
fn gradients_by_theta_agree_with_central_differences() {
    let spec = quickstart();
    let world = World::new(&spec.dataset.scene, 3).unwrap();
    let seen = world.particles();
    let piece = Workpiece::around(&seen);
    // A goal outside the dough, so that nearest neighbours do not change at every nudge.
    let goal: Vec<DVec3> = (0..8).map(|k| DVec3::new(0.2 * (k % 2) as f64 - 0.1, 0.03 * (k / 2) as f64, 0.1)).collect();
    let cost = GoalCost::new(CostSpec::Chamfer(ChamferSpec {}).build().unwrap(), goal).unwrap();
    for name in ["analytic", "learned", "hybrid"] {
        let model = model(&spec, name);
        for (tool_name, tool) in &spec.dataset.tool {
            let tool = tool.clone().build().unwrap();
            let middle = tool.space(&piece).at(&[0.5; 4][..tool.space(&piece).dimension()]);
            let scene = world.scene(tool.shape(), &tool.motion(&middle, &piece, 15).start);
            let problem = Problem::new(model.as_ref(), tool.as_ref(), scene, piece, &cost, 15).unwrap();
            let space = problem.space();
            // Squeezed to a sixth, dough under forty stiff substeps is chaotic, and no difference converges to any slope.
            let theta = space.at(&[0.45, 0.55, 0.5, 0.6][..space.dimension()]);
            let (_, slope) = problem.gradient(&theta).expect("these models have adjoints");
            let range = |i: usize| space.high[i] - space.low[i];
            let steepest = (0..theta.len()).map(|i| (slope[i] * range(i)).abs()).fold(0.0, f64::max);
            assert!(steepest > 1e-5, "{name}, {tool_name}: the action moves nothing");
            for i in 0..theta.len() {
                let cost = |nudges: &[f64]| {
                    let moved = |x: &f64| {
                        let mut theta = theta.clone();
                        theta[i] += x;
                        theta
                    };
                    problem.costs(&nudges.iter().map(moved).collect::<Vec<_>>())
                };
                let errors = REACHES
                    .map(|fraction| (slope_of(cost, fraction * range(i)) - slope[i]).abs() * range(i) / steepest);
                let least = errors.iter().copied().fold(f64::INFINITY, f64::min);
                assert!(least < 1e-3, "{name}, {tool_name}, θ{i}: errors {errors:?} of the steepest slope");
            }
        }
    }
}

#[test]
fn relabelling_particles_relabels_every_prediction_bit_for_bit() {
    let spec = quickstart();
    let world = World::new(&spec.dataset.scene, 4).unwrap();
    let tool = spec.dataset.tool["press_square"].clone().build().unwrap();
    let piece = Workpiece::around(&world.particles());
    let motion = tool.motion(&tool.space(&piece).at(&[0.5, 0.4, 0.1, 0.7]), &piece, 6);
    let scene = world.scene(tool.shape(), &motion.start);
    let count = scene.particles.len();
    let mut rng = stream(8, &[2]);
    let shuffled = |rng: &mut _| {
        let mut order: Vec<usize> = (0..count).collect();
        (1..count).rev().for_each(|i| order.swap(i, Rng::random_range(rng, 0..=i)));
        order
    };
    let orders: Vec<Vec<usize>> =
        [(0..count).rev().collect()].into_iter().chain((0..4).map(|_| shuffled(&mut rng))).collect();
    for name in NAMES {
        let model = model(&spec, name);
        let direct = model.rollout(&scene, &motion.controls);
        assert_ne!(direct[0], direct[6], "{name}: nothing moved");
        for order in &orders {
            let relabel = |x: &Particles| Particles {
                positions: order.iter().map(|&i| x.positions[i]).collect(),
                velocities: order.iter().map(|&i| x.velocities[i]).collect(),
            };
            let relabelled = Scene { particles: relabel(&scene.particles), ..scene.clone() };
            let after = model.rollout(&relabelled, &motion.controls);
            assert!(direct.iter().zip(&after).all(|(x, y)| relabel(x) == *y), "{name}");
        }
    }
}

#[test]
fn untrained_hybrids_predict_exactly_what_their_written_laws_do() {
    let spec = quickstart();
    let world = World::new(&spec.dataset.scene, 4).unwrap();
    let tool = spec.dataset.tool["press_square"].clone().build().unwrap();
    let piece = Workpiece::around(&world.particles());
    let motion = tool.motion(&tool.space(&piece).at(&[0.5, 0.4, 0.1, 0.7]), &piece, 6);
    let scene = world.scene(tool.shape(), &motion.start);
    let rollout = |name: &str| spec.model[name].dynamics.clone().build().unwrap().rollout(&scene, &motion.controls);
    let written = rollout("analytic");
    assert_ne!(written[0], written[6], "nothing moved");
    for name in ["hybrid", "residual", "neural_constants", "output_residual"] {
        assert!(rollout(name) == written, "{name}");
    }
    assert!(rollout("feature") != written, "its motion is the network's alone");
}
