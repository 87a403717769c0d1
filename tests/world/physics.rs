//! What dough does.
use crate::bench::*;
use glam::DVec3;
use pliant::state::{Control, Solid, ToolShape, TriangleMesh};
use pliant::tool::Motion;
use pliant::world::{DoughSpec, EllipsoidSpec, MaterialSpec, SceneSpec, StartSpec, World};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::sync::Arc;

#[test]
fn dough_rests_without_creeping() {
    let mut world = World::new(&spec(), 1).unwrap();
    let start = world.all_positions();
    assert!((extent(&start) - DVec3::new(0.06, 0.06, 0.03)).abs().max_element() < 0.0015, "settled {}", extent(&start));
    for _ in 0..30 {
        world.step(&Control::default());
    }
    let moved = start.iter().zip(world.all_positions()).map(|(a, b)| a.distance(b)).fold(0.0, f64::max);
    assert!(moved < 1e-4, "in 3 s a particle crept {moved} m");
}

#[test]
fn dough_keeps_a_pressed_shape_and_rubber_does_not() {
    let mut block = World::new(&spec(), 1).unwrap();
    let before = extent(&block.all_positions());
    block.execute(&plate(), &down_to(0.015, 0.01));
    let pressed = extent(&block.all_positions());
    assert!(pressed.z < 0.75 * before.z, "pressed from {before} to {pressed}");
    assert!(pressed.x > 1.2 * before.x && pressed.y > 1.2 * before.y, "pressed from {before} to {pressed}");
    for _ in 0..10 {
        block.step(&Control::default());
    }
    assert!((extent(&block.all_positions()) - pressed).abs().max_element() < 1e-3, "it goes on flowing");

    let elastic = MaterialSpec::Dough(DoughSpec { yield_strain: 0.0, ..dough() });
    let mut rubber = World::new(&SceneSpec { material: elastic, ..spec() }, 1).unwrap();
    let before = extent(&rubber.all_positions());
    rubber.execute(&plate(), &down_to(0.015, 0.01));
    for _ in 0..10 {
        rubber.step(&Control::default());
    }
    let after = extent(&rubber.all_positions());
    assert!((after - before).abs().max_element() < 0.05 * before.z, "rubber went from {before} to {after}");
}

#[test]
fn every_tool_leaves_its_mark() {
    let start = World::new(&spec(), 1).unwrap();
    let before = start.all_positions();
    let under = |low: DVec3, high: DVec3| -> Vec<usize> {
        (0..before.len()).filter(|&i| before[i].cmpge(low).all() && before[i].cmple(high).all()).collect()
    };
    let after = |tool: &Arc<ToolShape>, motion: &Motion| {
        let mut world = start.clone();
        world.execute(tool, motion);
        world.all_positions()
    };
    let at = |points: &[DVec3], rows: &[usize]| rows.iter().map(|&i| points[i]).collect::<Vec<_>>();
    let ceiling = top(&before) - 0.003;
    let (low, high) = (DVec3::new(-0.015, -0.015, ceiling), DVec3::new(0.015, 0.015, 1.0));

    let dent = under(low, high);
    let pressed = after(&press(), &down_to(0.015, 0.01));
    let depth = top(&before) - middle(&at(&pressed, &dent)).z;
    assert!(depth > 0.007, "the press left a dent of {depth} m");

    let waist = under(DVec3::new(-1.0, -0.006, -1.0), DVec3::new(1.0, 0.006, 1.0));
    let gripped = after(&fingers(), &grip(0.01));
    let width = extent(&at(&gripped, &waist)).x;
    assert!(width < 0.75 * extent(&before).x, "the gripper left a waist of {width} m");

    let track = under(DVec3::new(-0.02, -0.02, ceiling), DVec3::new(0.02, 0.02, 1.0));
    let rolled = after(&roller(), &roll(0.015));
    let depth = top(&before) - middle(&at(&rolled, &track)).z;
    assert!(depth > 0.007, "the roller left a track of {depth} m");
}

#[test]
fn dough_crushed_against_the_table_stays_above_it() {
    let mut world = World::new(&spec(), 1).unwrap();
    let motion = down_to(0.001, 0.01);
    world.take(&press(), &motion.start);
    for control in &motion.controls {
        world.step(control);
        let lowest = world.all_positions().iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
        assert!(lowest >= 0.0, "a particle at z = {lowest} m");
    }
}

#[test]
fn pressed_gripped_and_rolled_dough_keeps_its_volume_all_the_while() {
    let cases = [
        (press(), down_to(0.015, 0.01)),
        (press(), down_to(0.01, 0.01)),
        (plate(), down_to(0.012, 0.01)),
        (fingers(), grip(0.015)),
        (roller(), roll(0.012)),
    ];
    cases.into_par_iter().enumerate().for_each(|(case, (tool, motion))| {
        let mut world = World::new(&spec(), 1).unwrap();
        let volume = world.volume();
        world.take(&tool, &motion.start);
        for (step, control) in motion.controls.iter().enumerate() {
            world.step(control);
            let kept = world.volume() / volume;
            assert!((kept - 1.0).abs() < 0.02, "{kept} of the volume is left in step {step} of case {case}");
        }
    });
}

#[test]
fn random_motions_of_every_tool_leak_nothing_tear_nothing_and_keep_the_volume() {
    shipped_tools().par_iter().enumerate().for_each(|(i, (name, tool))| {
        let seed = i as u64;
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let kind = EllipsoidSpec { x: [0.05, 0.07], y: [0.05, 0.07], z: [0.025, 0.04], turn: [0.0, 1.5] };
        let start = if seed.is_multiple_of(2) { spec().start } else { StartSpec::Ellipsoid(kind) };
        let mut world = World::new(&SceneSpec { start, particles: 60, ..spec() }, seed).unwrap();
        let (volume, mut farthest) = (world.volume(), 0.0f64);
        for _ in 0..2 {
            let motion = random_motion(&world, tool.as_ref(), &mut rng);
            let before = world.all_positions();
            let away = middle(&before);
            world.take(tool.shape(), &motion.start);
            for control in &motion.controls {
                world.step(control);
                for (p, was) in world.all_positions().iter().zip(&before) {
                    assert!(p.is_finite() && p.z >= 0.0 && p.distance(away) < 0.12, "{name}: a particle at {p}");
                    farthest = farthest.max(p.distance(*was));
                }
                // Crushed thinner than a lattice cell, or under a blade thinner than one, dough gives way until it is let go.
                let kept = world.volume() / volume;
                assert!((0.8..1.03).contains(&kept), "{name}: {kept} of the volume is left");
            }
            let kept = world.volume() / volume;
            assert!((0.97..1.02).contains(&kept), "{name}: {kept} of the volume is left at the end");
        }
        assert!(farthest > 1e-3, "{name} moves nothing further than {farthest} m");
    });
}

#[test]
fn a_fast_tool_does_not_tunnel() {
    let start = World::new(&spec(), 1).unwrap();
    for (tool, below) in [(plate(), 0.01), (press(), 0.01)] {
        let mut world = start.clone();
        let before = world.all_positions();
        // 0.2 m/s, down to a third of the height, and held.
        let up = vec![at(0.0, 0.0, 0.05 + below)];
        let down = vec![at(0.0, 0.0, 0.01 + below)];
        world.take(&tool, &up);
        for control in path(&[(0, up), (2, down.clone()), (4, down)]).controls {
            world.step(&control);
        }
        for (p, was) in world.all_positions().iter().zip(&before) {
            let under = was.truncate().abs().max_element() < 0.012;
            assert!(!under || p.z < 0.01 + 0.004, "from {was} through the tool to {p}");
        }
    }
}

#[test]
fn a_tool_far_above_touches_nothing() {
    let start = World::new(&spec(), 1).unwrap();
    let (mut idle, mut busy) = (start.clone(), start);
    let pass = path(&[(0, vec![at(-0.1, 0.0, 0.15)]), (10, vec![at(0.1, 0.0, 0.15)])]);
    busy.execute(&press(), &pass);
    (0..10).for_each(|_| idle.step(&Control::default()));
    assert!(busy.all_positions() == idle.all_positions());
}

#[test]
fn a_box_given_as_a_mesh_presses_as_the_box() {
    let half = DVec3::new(0.02, 0.02, 0.01);
    let corner = |i: u32| half * DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)) * 2.0 - half;
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = faces.iter().flat_map(|f| [[f[0], f[1], f[2]], [f[0], f[2], f[3]]]).collect();
    let mesh = TriangleMesh::new((0..8).map(corner).collect(), triangles).unwrap();
    let start = World::new(&spec(), 1).unwrap();
    let after = |tool: Arc<ToolShape>| {
        let mut world = start.clone();
        world.execute(&tool, &down_to(0.015, 0.01));
        world.all_positions()
    };
    let (boxed, meshed) = (after(press()), after(tool(&[Solid::Mesh(Arc::new(mesh))])));
    let apart = boxed.iter().zip(&meshed).map(|(a, b)| a.distance(*b)).sum::<f64>() / boxed.len() as f64;
    assert!(apart < 0.002, "{apart} m apart on average");
}
