//! The fluid, alone and with rigid bodies in it.
use crate::bench::*;
use glam::{DVec2, DVec3};
use pliant::state::{Control, Pose, Solid};
use pliant::world::{
    BlockSpec, DropsSpec, FluidSpec, MaterialSpec, PieceSpec, RigidSpec, SceneSpec, SolverSpec, StartSpec, WallsSpec,
    World,
};
use rayon::prelude::*;

const SPACING: f64 = 0.01;

fn water() -> MaterialSpec {
    MaterialSpec::Fluid(FluidSpec { density: 1000.0, viscosity: 0.02 })
}

fn bath(walls: DVec2) -> SceneSpec {
    let half = walls / 2.0;
    SceneSpec {
        material: water(),
        spacing: SPACING,
        particles: 1,
        interval: 0.05,
        solver: SolverSpec { steps: 25, substeps: 2, sweeps: 4 },
        walls: Some(WallsSpec { x: [-half.x, half.x], y: [-half.y, half.y] }),
        ..spec()
    }
}

fn cube(side: f64) -> StartSpec {
    StartSpec::Block(BlockSpec { x: [side; 2], y: [side; 2], z: [side; 2], turn: [0.0; 2] })
}

fn piece(density: f64, side: f64, raised: f64) -> PieceSpec {
    let material = MaterialSpec::Rigid(RigidSpec { density, friction: 0.2, restitution: 0.0 });
    PieceSpec { material, start: cube(side), at: [[0.0; 2]; 2], raised: [raised; 2] }
}

fn wait(world: &mut World, seconds: f64) {
    (0..(seconds / world.interval()).round() as usize).for_each(|_| world.step(&Control::default()));
}

/// The heights of the fluid's surface above the points that `at` holds: half a spacing over each column's highest particle.
fn level(points: &[DVec3], at: impl Fn(DVec3) -> bool) -> f64 {
    let mut tops = std::collections::BTreeMap::new();
    for p in points.iter().filter(|p| at(**p)) {
        let column = (p.truncate() / (1.5 * SPACING)).floor().as_ivec2();
        let top = tops.entry((column.x, column.y)).or_insert(0.0f64);
        *top = top.max(p.z);
    }
    tops.values().sum::<f64>() / tops.len() as f64 + SPACING / 2.0
}

#[test]
fn in_the_air_a_fluid_falls_as_everything_falls() {
    let mut world = standing(&bath(DVec2::splat(0.3)), DVec3::splat(0.04), DVec2::ZERO, 0.5);
    let start = world.all_positions();
    for i in 1..=5 {
        wait(&mut world, 0.05);
        let time = 0.05 * f64::from(i);
        let ahead = GRAVITY * time * 0.002 / 2.0;
        for (now, then) in world.all_positions().iter().zip(&start) {
            let error = (*now - *then + 0.5 * GRAVITY * time * time * DVec3::Z).length();
            assert!(error <= 1.02 * ahead + 1e-5, "{error} m off after {time} s, {ahead} expected");
        }
    }
}

#[test]
fn a_column_breaks_to_the_level_that_its_volume_fills_and_its_energy_never_grows() {
    let (room, size) = (DVec2::new(0.12, 0.06), DVec3::new(0.06, 0.06, 0.1));
    let mut world = standing(&bath(room), size, DVec2::new(-0.03, 0.0), 0.0);
    let mut before = world.all_positions();
    let began = before.iter().map(|p| GRAVITY * p.z).sum::<f64>();
    for _ in 0..60 {
        wait(&mut world, 0.05);
        let now = world.all_positions();
        let moving: f64 = now.iter().zip(&before).map(|(a, b)| 0.5 * ((*a - *b) / 0.05).length_squared()).sum();
        let held: f64 = now.iter().map(|p| GRAVITY * p.z).sum();
        // A mean speed over the interval is below the speed, never above.
        assert!(moving + held < began, "{} of an energy of {began}", moving + held);
        before = now;
    }
    let expected = size.element_product() / (room.x * room.y);
    let all = world.all_positions();
    let found = level(&all, |_| true);
    assert!((found / expected - 1.0).abs() < 0.1, "level at {found}, {expected} expected");
    let sides = [-1.0, 1.0].map(|side| level(&all, |p| p.x * side > 0.02));
    assert!((sides[0] - sides[1]).abs() < 0.1 * expected, "levels {sides:?}");
    assert!(all.iter().all(|p| p.z > 0.0 && p.x.abs() < 0.06 && p.y.abs() < 0.03), "a particle is in a wall");
}

#[test]
fn connected_basins_find_the_same_level() {
    let spec = bath(DVec2::new(0.14, 0.05));
    let mut world = standing(&spec, DVec3::new(0.06, 0.05, 0.12), DVec2::new(-0.04, 0.0), 0.0);
    // A wall 2 cm thick between them, open for 2.5 cm above the table.
    let wall = tool(&[Solid::Cuboid { half: DVec3::new(0.01, 0.05, 0.1) }]);
    let hold = vec![at(0.0, 0.0, 0.125)];
    world.take(&wall, &hold);
    let control = Control { poses: hold };
    (0..120).for_each(|_| world.step(&control));
    let all = world.all_positions();
    let [left, right] = [-1.0, 1.0].map(|side| level(&all, |p| p.x * side > 0.015));
    assert!(right > 0.035, "nothing went through: {left} and {right}");
    assert!((left - right).abs() < 0.1 * left, "levels {left} and {right}");
    assert!(all.iter().all(|p| p.x.abs() > 0.008 || p.z < 0.027), "a particle is in the wall");
}

/// A board, which floats upright at every density; a cube would lie on its edge.
#[test]
fn a_board_floats_as_deep_as_its_density_says_and_a_heavy_one_sinks() {
    let (side, height) = (0.06, 0.03);
    let start = StartSpec::Block(BlockSpec { x: [side; 2], y: [side; 2], z: [height; 2], turn: [0.0; 2] });
    let found: Vec<f64> = [300.0, 700.0, 1600.0]
        .into_par_iter()
        .map(|density| {
            let mut spec = bath(DVec2::splat(0.12));
            spec.beside.insert("board".into(), PieceSpec { start: start.clone(), ..piece(density, 0.0, 0.06) });
            let mut world = standing(&spec, DVec3::new(0.12, 0.12, 0.05), DVec2::ZERO, 0.0);
            let corners = 7 * 7 * 4;
            wait(&mut world, 2.5);
            let all = world.all_positions();
            // The board comes last.
            let (fluid, body) = all.split_at(all.len() - corners);
            let bottom = body.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
            assert!(top(body) - bottom < height + 0.01, "{density}: tilted, from {bottom} to {}", top(body));
            let around = level(fluid, |p| p.truncate().abs().max_element() > side / 2.0 + SPACING);
            (around - middle(body).z) / height + 0.5
        })
        .collect();
    for (depth, expected) in found.iter().zip([0.3, 0.7]) {
        assert!((depth - expected).abs() < 0.12, "{found:?} of its height deep");
    }
    assert!(found[2] > 1.2, "a heavy board floats: {found:?}");
}

#[test]
fn a_box_thrown_into_a_falling_block_gives_it_what_it_loses() {
    let mut spec = bath(DVec2::splat(1.0));
    spec.walls = None;
    let mut thrown = piece(600.0, 0.03, 1.0);
    thrown.at = [[0.08; 2], [0.002; 2]];
    spec.beside.insert("cube".into(), thrown);
    let mut world = standing(&spec, DVec3::new(0.06, 0.06, 0.06), DVec2::ZERO, 0.99);
    let count = world.all_positions().len() - 64;
    world.kick_piece(1, DVec3::new(-0.6, 0.0, 0.0));
    let (drop, body) = (1000.0 * SPACING.powi(3), 600.0 * 0.03f64.powi(3));
    let carried = |before: &[DVec3], after: &[DVec3]| {
        let moved = |from: usize, to: usize| (from..to).map(|i| after[i] - before[i]).sum::<DVec3>();
        [drop * moved(0, count), body * moved(count, count + 64) / 64.0].map(|p| (p / 0.05).truncate())
    };
    let mut before = world.all_positions();
    let (mut first, mut last) = ([DVec2::ZERO; 2], [DVec2::ZERO; 2]);
    for step in 0..8 {
        wait(&mut world, 0.05);
        let after = world.all_positions();
        last = carried(&before, &after);
        if step == 0 {
            first = last;
        }
        let (sum, whole) = (last[0] + last[1], first[0] + first[1]);
        // While they push each other, the box follows a physics step behind.
        let share = if step < 5 { 0.05 } else { 0.01 };
        assert!((sum - whole).length() < share * whole.length(), "momentum went from {whole} to {sum} in step {step}");
        before = after;
    }
    assert!(last[0].length() > 0.2 * first[1].length(), "the fluid was hardly hit: {last:?}");
}

#[test]
fn a_shaken_box_keeps_every_particle() {
    let mut spec = bath(DVec2::splat(1.0));
    spec.walls = None;
    let mut world = standing(&spec, DVec3::new(0.06, 0.06, 0.06), DVec2::ZERO, 0.0);
    let side = Solid::Cuboid { half: DVec3::new(0.02, 0.09, 0.1) };
    let front = Solid::Cuboid { half: DVec3::new(0.06, 0.02, 0.1) };
    let container = tool(&[side.clone(), side, front.clone(), front]);
    let poses = |x: f64| -> Vec<Pose> {
        vec![at(x - 0.06, 0.0, 0.1), at(x + 0.06, 0.0, 0.1), at(x, -0.06, 0.1), at(x, 0.06, 0.1)]
    };
    world.take(&container, &poses(0.0));
    for i in 1..=60 {
        let x = 0.03 * (std::f64::consts::TAU * 0.05 * f64::from(i)).sin();
        world.step(&Control { poses: poses(x) });
        for p in world.all_positions() {
            let inside = (p.x - x).abs() < 0.04 && p.y.abs() < 0.04 && p.z > 0.0 && p.z < 0.3;
            assert!(inside, "a particle at {p} in step {i}, the box at {x}");
        }
    }
}

#[test]
fn two_drops_fall_and_merge() {
    let pieces = |points: &[DVec3]| {
        let mut left: Vec<usize> = (0..points.len()).collect();
        let mut found = 0;
        while let Some(first) = left.pop() {
            found += 1;
            let mut front = vec![first];
            while let Some(i) = front.pop() {
                let (near, far) = left.iter().partition(|&&j| points[i].distance(points[j]) < 1.6 * SPACING);
                front.extend::<Vec<usize>>(near);
                left = far;
            }
        }
        found
    };
    let drops = DropsSpec { radius: [0.022, 0.026], gap: [0.03; 2], aside: [0.01; 2], turn: [0.0, 3.0] };
    let spec = SceneSpec { start: StartSpec::Drops(drops), ..bath(DVec2::splat(0.1)) };
    let mut world = World::new(&spec, 3).unwrap();
    assert_eq!(pieces(&world.all_positions()), 2);
    wait(&mut world, 2.0);
    assert_eq!(pieces(&world.all_positions()), 1);
}

#[test]
fn a_fluid_with_a_box_continues_from_a_snapshot_byte_for_byte() {
    let mut spec = bath(DVec2::splat(0.1));
    spec.beside.insert("cube".into(), piece(500.0, 0.03, 0.05));
    let mut going_on = standing(&spec, DVec3::new(0.06, 0.1, 0.05), DVec2::new(-0.02, 0.0), 0.0);
    let (mut restored, mut cloned) = (going_on.clone(), going_on.clone());
    for _ in 0..10 {
        restored = World::restore(&restored.snapshot()).unwrap();
        for world in [&mut going_on, &mut restored, &mut cloned] {
            world.step(&Control::default());
        }
        assert!(going_on.snapshot() == restored.snapshot() && going_on.snapshot() == cloned.snapshot());
    }
}
