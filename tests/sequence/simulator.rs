//! The simulator as the model of a sequence: it predicts exactly what then happens.
use glam::DVec3;
use pliant::compare::CompareSpec;
use pliant::config;
use pliant::metric::{ChamferSpec, CostSpec, GoalCost};
use pliant::model::{Cost, Oracle};
use pliant::planner::Objective;
use pliant::problem::Sequence;
use pliant::tool::{Tool, Workpiece};
use pliant::world::World;

#[test]
fn the_simulator_predicts_two_actions_in_a_row_bit_for_bit() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/configs/compare/quickstart.toml");
    let spec = config::load::<CompareSpec>(path.as_ref(), &[]).unwrap().spec;
    let tool = |name: &str| spec.dataset.tool[name].clone().build().unwrap();
    let (press, gripper) = (tool("press_square"), tool("gripper_rod"));
    let mut world = World::new(&spec.dataset.scene, 2).unwrap();
    let particles = world.particles();
    let piece = Workpiece::around(&particles);
    let goal = particles.positions.iter().map(|p| *p * DVec3::new(1.2, 1.0, 0.7)).collect();
    let cost = GoalCost::new(CostSpec::Chamfer(ChamferSpec {}).build().unwrap(), goal).unwrap();
    let tools: Vec<&dyn Tool> = vec![press.as_ref(), gripper.as_ref()];
    let start = press.motion(&press.space(&piece).at(&[0.5; 4]), &piece, 15).start;
    let problem = Sequence::new(&Oracle, tools, world.scene(press.shape(), &start), piece, &cost, 15).unwrap();
    let plan = problem.space().at(&[0.4, 0.6, 0.1, 0.5, 0.5, 0.3, 0.2]);
    let promised = problem.costs(std::slice::from_ref(&plan))[0];
    for (stroke, tool) in problem.strokes(&plan).unwrap().iter().zip([&press, &gripper]) {
        assert_eq!(stroke.start, world.particles().positions);
        world.execute(tool.shape(), &stroke.motion);
    }
    assert_eq!(cost.at(0, 0, &world.particles()), promised);
}
