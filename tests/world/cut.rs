//! Dough that is cut: what comes apart, what stays whole, and that nothing is lost.
use crate::bench::*;
use glam::{DQuat, DVec3};
use pliant::state::{Solid, ToolShape};
use pliant::tool::{Tool, Workpiece};
use pliant::world::World;
use std::collections::BTreeMap;
use std::sync::Arc;

/// The block, cut by `tool` at the middle of its bounding box, turned by `rotation`.
fn cut(tool: &dyn Tool, rotation: Option<f64>) -> World {
    let mut world = World::new(&spec(), 1).unwrap();
    let theta: Vec<f64> = [0.0, 0.0].into_iter().chain(rotation).collect();
    let motion = tool.motion(&theta, &Workpiece::around(&world.particles()), 15);
    world.execute(tool.shape(), &motion);
    world
}

/// The particles of every body.
fn bodies(world: &World) -> Vec<Vec<DVec3>> {
    let mut bodies: BTreeMap<usize, Vec<DVec3>> = BTreeMap::new();
    for (body, point) in world.bodies().into_iter().zip(world.particles().positions) {
        bodies.entry(body).or_default().push(point);
    }
    bodies.into_values().collect()
}

#[test]
fn a_knife_leaves_two_halves_on_its_two_sides() {
    let knife = shipped_tool("knife");
    for turn in [0.0, 0.6, -1.2] {
        let world = cut(knife.as_ref(), Some(turn));
        let halves = bodies(&world);
        assert_eq!(halves.len(), 2, "turned by {turn}");
        let across = DQuat::from_rotation_z(turn) * DVec3::X;
        let sides: Vec<f64> = halves.iter().map(|half| middle(half).dot(across)).collect();
        assert!(sides[0] * sides[1] < 0.0 && sides.iter().all(|s| s.abs() > 0.008), "turned by {turn}: {sides:?}");
        for (half, side) in halves.iter().zip(sides) {
            let astray = half.iter().map(|p| -side.signum() * p.dot(across)).fold(0.0, f64::max);
            assert!(astray < 0.001, "turned by {turn}: {astray} m on the other side");
        }
    }
}

#[test]
fn a_circular_cutter_leaves_a_disc_and_a_ring() {
    let world = cut(shipped_tool("cutter_circle").as_ref(), None);
    let mut parts = bodies(&world);
    assert_eq!(parts.len(), 2);
    parts.sort_by(|a, b| extent(a).x.total_cmp(&extent(b).x));
    let radius = |part: &[DVec3]| part.iter().map(|p| p.truncate().length()).collect::<Vec<_>>();
    let (disc, ring) = (radius(&parts[0]), radius(&parts[1]));
    assert!(disc.iter().all(|r| *r < 0.022), "the disc reaches to {:?}", disc.iter().copied().fold(0.0, f64::max));
    assert!(ring.iter().all(|r| *r > 0.018), "the ring reaches to {:?}", ring.iter().copied().fold(1.0, f64::min));
    assert!(middle(&parts[1]).truncate().length() < 0.004, "the ring is not around the disc");
}

#[test]
fn a_half_that_is_pushed_away_leaves_the_other_and_an_uncut_one_takes_it_along() {
    // Pushes the left half along the cut.
    let board = tool(&[Solid::Cuboid { half: DVec3::new(0.014, 0.005, 0.03) }]);
    let push = |mut world: World| {
        let before = world.particles().positions;
        world.execute(&board, &path(&[(0, vec![at(-0.025, -0.1, 0.031)]), (10, vec![at(-0.025, 0.0, 0.031)])]));
        let after = world.particles().positions;
        let moved = |side: f64| {
            let of: Vec<f64> =
                (0..before.len()).filter(|&i| before[i].x * side > 0.0).map(|i| after[i].y - before[i].y).collect();
            of.iter().sum::<f64>() / of.len() as f64
        };
        (moved(-1.0), moved(1.0))
    };
    let (left, right) = push(cut(shipped_tool("knife").as_ref(), Some(0.0)));
    assert!(left > 0.02 && right.abs() < 0.3 * left, "the left half moved {left} m, the right one {right} m");
    let (left, right) = push(World::new(&spec(), 1).unwrap());
    assert!(right > 0.3 * left, "of a whole block the left half moved {left} m, the right one {right} m");
}

#[test]
fn cutting_loses_no_volume_and_its_future_is_its_states() {
    for (name, theta) in [("knife", vec![0.004, -0.003, 0.4]), ("cutter_circle", vec![0.002, 0.003])] {
        let tool = shipped_tool(name);
        let mut world = World::new(&spec(), 1).unwrap();
        let volume = world.volume();
        let motion = tool.motion(&theta, &Workpiece::around(&world.particles()), 15);
        world.take(tool.shape(), &motion.start);
        for control in &motion.controls {
            let (mut restored, mut cloned) = (World::restore(&world.snapshot()).unwrap(), world.clone());
            for copy in [&mut world, &mut restored, &mut cloned] {
                copy.step(control);
            }
            assert!(world.snapshot() == restored.snapshot() && world.snapshot() == cloned.snapshot(), "{name}");
        }
        for _ in 0..10 {
            world.step(&Default::default());
        }
        let kept = world.volume() / volume;
        assert!((kept - 1.0).abs() < 0.02, "{name}: {kept} of the volume is left");
        assert_eq!(world.particles().len(), spec().particles);
    }
}

#[test]
fn a_notch_and_a_blunt_blade_leave_one_body() {
    let blade = |cuts: bool| {
        let knife = shipped_tool("knife");
        Arc::new(ToolShape { parts: knife.shape().parts.clone(), cuts })
    };
    for (tool, lowest, count) in [(blade(true), 0.015, 1), (blade(false), 0.001, 1), (blade(true), 0.001, 2)] {
        let mut world = World::new(&spec(), 1).unwrap();
        world.execute(&tool, &down_to(lowest, 0.03));
        assert_eq!(bodies(&world).len(), count, "down to {lowest} m");
    }
}
