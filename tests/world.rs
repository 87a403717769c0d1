//! The ground truth: dough rests, yields, keeps its volume and the table its place; and a world's future is its state's alone.
use glam::{DQuat, DVec3};
use pliant::model::{Oracle, WorldModel};
use pliant::state::{Control, Part, Pose, Snapshot, Solid, ToolShape, TriangleMesh};
use pliant::tool::Motion;
use pliant::world::{BlockSpec, EllipsoidSpec, MaterialSpec, SceneSpec, SolverSpec, StartSpec, World};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::sync::Arc;

fn spec() -> SceneSpec {
    SceneSpec {
        material: MaterialSpec {
            density: 1200.0,
            young_modulus: 2e4,
            poisson_ratio: 0.499,
            damping_ratio: 1.0,
            yield_strain: 0.02,
            creep_rate: 60.0,
            largest_set: 0.8,
            friction: 0.5,
        },
        start: StartSpec::Block(BlockSpec { x: [0.06; 2], y: [0.06; 2], z: [0.03; 2], turn: [0.0; 2] }),
        spacing: 0.01,
        particles: 120,
        interval: 0.1,
        solver: SolverSpec { steps: 2, substeps: 8, sweeps: 4 },
    }
}

fn tool(parts: &[Solid]) -> Arc<ToolShape> {
    let part = |solid: &Solid| Part { solid: solid.clone(), surface: Vec::new() };
    Arc::new(ToolShape { parts: parts.iter().map(part).collect() })
}

fn press() -> Arc<ToolShape> {
    tool(&[Solid::Cuboid { half: DVec3::new(0.02, 0.02, 0.01) }])
}

fn plate() -> Arc<ToolShape> {
    tool(&[Solid::Cuboid { half: DVec3::new(0.1, 0.1, 0.01) }])
}

fn fingers() -> Arc<ToolShape> {
    let finger = Solid::Cuboid { half: DVec3::new(0.0059, 0.01, 0.0253) };
    tool(&[finger.clone(), finger])
}

fn roller() -> Arc<ToolShape> {
    tool(&[Solid::Cylinder { radius: 0.02, half_length: 0.035 }])
}

fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose { translation: DVec3::new(x, y, z), rotation: DQuat::IDENTITY }
}

/// Through way points at (step, pose of each part), straight in between.
fn path(points: &[(usize, Vec<Pose>)]) -> Motion {
    let leg = |pair: &[(usize, Vec<Pose>)]| -> Vec<Control> {
        let ((from, a), (to, b)) = (&pair[0], &pair[1]);
        let way = |i| (i - from) as f64 / (to - from) as f64;
        (from + 1..=*to)
            .map(|i| Control { poses: a.iter().zip(b).map(|(a, b)| a.toward(b, way(i))).collect() })
            .collect()
    };
    Motion { start: points[0].1.clone(), controls: points.windows(2).flat_map(leg).collect() }
}

/// Down until the tool's lower face, `below` its origin, is at height z; then up again.
fn down_to(z: f64, below: f64) -> Motion {
    let up = vec![at(0.0, 0.0, 0.045 + below)];
    path(&[(0, up.clone()), (10, vec![at(0.0, 0.0, z + below)]), (15, up)])
}

fn grip(width: f64) -> Motion {
    let open = |gap: f64| vec![at(-gap / 2.0 - 0.0059, 0.0, 0.0303), at(gap / 2.0 + 0.0059, 0.0, 0.0303)];
    path(&[(0, open(0.09)), (10, open(width)), (15, open(0.09))])
}

fn roll(z: f64) -> Motion {
    let p =
        |x: f64, z: f64| Pose { translation: DVec3::new(x, 0.0, z + 0.02), rotation: DQuat::from_rotation_y(x / 0.02) };
    path(&[(0, vec![p(-0.03, 0.045)]), (4, vec![p(-0.03, z)]), (12, vec![p(0.03, z)]), (15, vec![p(0.03, 0.045)])])
}

fn extent(points: &[DVec3]) -> DVec3 {
    let low = points.iter().fold(DVec3::INFINITY, |l, p| l.min(*p));
    points.iter().fold(DVec3::NEG_INFINITY, |h, p| h.max(*p)) - low
}

fn top(points: &[DVec3]) -> f64 {
    points.iter().map(|p| p.z).fold(0.0, f64::max)
}

fn middle(points: &[DVec3]) -> DVec3 {
    points.iter().sum::<DVec3>() / points.len() as f64
}

/// A random use of one of the three tools, within the bounds of RoboCook's.
fn random_action(world: &World, rng: &mut ChaCha8Rng) -> (Arc<ToolShape>, Motion) {
    let all = world.all_positions();
    let (centre, height) = (middle(&all).with_z(0.0), top(&all));
    let rotation = DQuat::from_rotation_z(rng.random_range(-1.57..1.57));
    let aim = |offset: DVec3, local: DQuat| Pose { translation: centre + offset, rotation: rotation * local };
    let mut between = |low: f64, high: f64| rng.random_range(low..high);
    let clear = height + 0.015;
    match between(0.0, 3.0) as usize {
        0 => {
            let (x, y, z) = (between(-0.02, 0.02), between(-0.02, 0.02), between(0.2, 0.9) * height);
            let pose = |z: f64| vec![aim(DVec3::new(x, y, z + 0.01), DQuat::IDENTITY)];
            (press(), path(&[(0, pose(clear)), (10, pose(z)), (15, pose(clear))]))
        }
        1 => {
            let width = between(0.005, 0.03);
            let finger = |x: f64| aim(rotation * DVec3::X * x + DVec3::Z * 0.0303, DQuat::IDENTITY);
            let pose = |gap: f64| vec![finger(-gap / 2.0 - 0.0059), finger(gap / 2.0 + 0.0059)];
            (fingers(), path(&[(0, pose(0.11)), (10, pose(width)), (15, pose(0.11))]))
        }
        _ => {
            let z = between(0.4, 0.9) * height;
            let roll = |x: f64| DQuat::from_rotation_y(x / 0.02);
            let pose = |x: f64, z: f64| vec![aim(rotation * DVec3::X * x + DVec3::Z * (z + 0.02), roll(x))];
            let points = [(0, pose(-0.06, clear)), (4, pose(-0.06, z)), (12, pose(0.06, z)), (15, pose(0.06, clear))];
            (roller(), path(&points))
        }
    }
}

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
    let mut dough = World::new(&spec(), 1).unwrap();
    let before = extent(&dough.all_positions());
    dough.execute(&plate(), &down_to(0.015, 0.01));
    let pressed = extent(&dough.all_positions());
    assert!(pressed.z < 0.75 * before.z, "pressed from {before} to {pressed}");
    assert!(pressed.x > 1.2 * before.x && pressed.y > 1.2 * before.y, "pressed from {before} to {pressed}");
    for _ in 0..10 {
        dough.step(&Control::default());
    }
    assert!((extent(&dough.all_positions()) - pressed).abs().max_element() < 1e-3, "it goes on flowing");

    let elastic = MaterialSpec { yield_strain: 0.0, ..spec().material };
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
fn random_actions_leak_nothing_tear_nothing_and_keep_the_volume() {
    (0..6u64).into_par_iter().for_each(|seed| {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let kind = EllipsoidSpec { x: [0.05, 0.07], y: [0.05, 0.07], z: [0.025, 0.04], turn: [0.0, 1.5] };
        let start = if seed % 2 == 0 { spec().start } else { StartSpec::Ellipsoid(kind) };
        let mut world = World::new(&SceneSpec { start, particles: 60, ..spec() }, seed).unwrap();
        let volume = world.volume();
        for _ in 0..3 {
            let (tool, motion) = random_action(&world, &mut rng);
            let away = middle(&world.all_positions());
            world.take(&tool, &motion.start);
            for control in &motion.controls {
                world.step(control);
                for p in world.all_positions() {
                    assert!(p.is_finite() && p.z >= 0.0 && p.distance(away) < 0.12, "seed {seed}: a particle at {p}");
                }
            }
            let kept = world.volume() / volume;
            assert!((0.92..1.04).contains(&kept), "seed {seed}: {kept} of the volume is left");
        }
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

#[test]
fn clones_and_snapshots_continue_byte_for_byte() {
    let mut world = World::new(&spec(), 5).unwrap();
    for (tool, motion) in [(press(), down_to(0.012, 0.01)), (fingers(), grip(0.02)), (roller(), roll(0.015))] {
        world.take(&tool, &motion.start);
        // The tool is deep in the dough when the copies are taken.
        motion.controls[..9].iter().for_each(|control| world.step(control));
        let snapshot = world.snapshot();
        let (mut restored, mut cloned) = (World::restore(&snapshot).unwrap(), world.clone());
        assert_eq!(restored.snapshot(), snapshot);
        for control in &motion.controls[9..] {
            for copy in [&mut world, &mut restored, &mut cloned] {
                copy.step(control);
            }
            assert!(world.particles() == restored.particles() && world.particles() == cloned.particles());
            assert_eq!(world.snapshot(), restored.snapshot());
            assert_eq!(world.snapshot(), cloned.snapshot());
        }
    }
}

#[test]
fn the_same_seed_gives_the_same_bytes_whatever_the_thread_count() {
    let ranges = BlockSpec { x: [0.05, 0.07], y: [0.05, 0.07], z: [0.025, 0.035], turn: [0.0, 1.0] };
    let spec = SceneSpec { start: StartSpec::Block(ranges), particles: 60, ..spec() };
    let run = |threads: usize| -> Vec<Snapshot> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let one = |seed: u64| {
            let mut world = World::new(&spec, seed).unwrap();
            let (tool, motion) = random_action(&world, &mut ChaCha8Rng::seed_from_u64(seed));
            world.execute(&tool, &motion);
            world.snapshot()
        };
        pool.install(|| (0..4u64).into_par_iter().map(one).collect())
    };
    let serial = run(1);
    assert!(serial == run(2), "two threads give other bytes");
    assert!(serial[0] != serial[1], "seeds differ");
}

#[test]
fn the_oracle_predicts_execution_bit_for_bit() {
    let mut world = World::new(&spec(), 2).unwrap();
    for (tool, motion) in [(fingers(), grip(0.015)), (press(), down_to(0.012, 0.01)), (roller(), roll(0.015))] {
        let scene = world.scene(&tool, &motion.start);
        Oracle.accepts(&scene).unwrap();
        let alone = Oracle.rollout(&scene, &motion.controls);
        let many = Oracle.rollouts(&scene, &[motion.controls.clone(), motion.controls.clone()]);
        let truth = world.execute(&tool, &motion);
        assert!(scene.particles == truth[0] && alone == truth && many == [truth.clone(), truth]);
    }
    let mut scene = world.scene(&press(), &[at(0.0, 0.0, 0.1)]);
    scene.snapshot = None;
    assert!(Oracle.accepts(&scene).unwrap_err().to_string().contains("simulator"));
}

#[test]
fn hostile_snapshots_are_refused_in_a_sentence() {
    let Snapshot(bytes) = World::new(&spec(), 1).unwrap().snapshot();
    let refused = |bytes: &[u8]| match World::restore(&Snapshot(bytes.into())) {
        Ok(_) => panic!("accepted"),
        Err(error) => assert!(error.to_string().contains("snapshot"), "{error}"),
    };
    for length in (0..bytes.len()).step_by(bytes.len() / 40).chain([1, 14, 15, 16, 46, 47, 48, bytes.len() - 1]) {
        refused(&bytes[..length]);
    }
    for place in (0..bytes.len()).step_by(bytes.len() / 40) {
        let mut damaged = bytes.to_vec();
        damaged[place] ^= 0x40;
        refused(&damaged);
    }
}

#[test]
fn velocities_are_backward_differences() {
    let mut world = World::new(&spec(), 1).unwrap();
    let rollout = world.execute(&press(), &down_to(0.015, 0.01));
    assert_eq!(rollout.len(), 16);
    assert!(rollout[0].velocities.iter().all(|v| *v == DVec3::ZERO));
    for pair in rollout.windows(2) {
        for ((now, then), velocity) in pair[1].positions.iter().zip(&pair[0].positions).zip(&pair[1].velocities) {
            assert!((*now - *then - *velocity * 0.1).length() < 1e-12);
        }
    }
    assert!(rollout[8].velocities.iter().any(|v| v.length() > 0.01));
}

#[test]
fn dough_fills_a_perceived_region_where_it_lies() {
    let (centre, radius) = (DVec3::new(0.1, -0.05, 0.0), 0.035);
    let ball = |p: DVec3| p.distance(centre) < radius;
    let bounds = (centre - DVec3::splat(radius).with_z(0.0), centre + DVec3::splat(radius));
    let world = World::around(&SceneSpec { particles: 60, ..spec() }, &ball, bounds).unwrap();
    let half_ball = 2.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
    assert!((world.volume() / half_ball - 1.0).abs() < 0.15, "{} of the ball's volume", world.volume() / half_ball);
    assert!((middle(&world.all_positions()) - centre).truncate().length() < 0.002);
    assert!(world.surface().len() < world.all_positions().len());
    let nothing = World::around(&spec(), &|_| false, bounds).err().unwrap().to_string();
    assert!(nothing.contains("spacing"), "{nothing}");
}

#[test]
fn model_particles_spread_over_the_dough() {
    let world = World::new(&spec(), 1).unwrap();
    let (all, chosen) = (world.all_positions(), world.particles().positions);
    assert_eq!(chosen.len(), 120);
    let nearest = |p: &DVec3| chosen.iter().map(|q| q.distance(*p)).fold(f64::INFINITY, f64::min);
    let gap = all.iter().map(nearest).fold(0.0, f64::max);
    assert!(gap < 0.0115, "a particle is {gap} m from the next chosen one");
}

#[test]
fn impossible_scenes_name_their_key() {
    let material = |change: fn(&mut MaterialSpec)| {
        let mut spec = spec();
        change(&mut spec.material);
        spec
    };
    let wide = StartSpec::Block(BlockSpec { x: [0.06, 0.01], y: [0.06; 2], z: [0.03; 2], turn: [0.0; 2] });
    for (spec, key) in [
        (material(|m| m.density = -1.0), "material.density"),
        (material(|m| m.poisson_ratio = 0.5), "material.poisson_ratio"),
        (material(|m| m.friction = f64::NAN), "material.friction"),
        (SceneSpec { spacing: 0.0, ..spec() }, "scene.spacing"),
        (SceneSpec { particles: 10_000, ..spec() }, "scene.particles"),
        (SceneSpec { solver: SolverSpec { sweeps: 0, ..spec().solver }, ..spec() }, "scene.solver.sweeps"),
        (SceneSpec { start: wide, ..spec() }, "start.x"),
    ] {
        let error = World::new(&spec, 0).err().expect(key).to_string();
        assert!(error.contains(key), "{error}");
    }
}

#[test]
fn the_shipped_scene_builds_at_both_ends_of_its_ranges() {
    let read = |path: &str| std::fs::read_to_string(path).unwrap().parse::<toml_edit::DocumentMut>().unwrap();
    let mut scene = read("configs/scene/dough.toml");
    scene["material"] = toml_edit::Item::Table(read("configs/material/dough.toml").as_table().clone());
    let shipped: SceneSpec = toml_edit::de::from_document(scene).unwrap();
    let StartSpec::Block(ranges) = &shipped.start else { panic!("the shipped start is a block") };
    for end in [0, 1] {
        let of = |range: [f64; 2]| [range[end]; 2];
        let block = BlockSpec { x: of(ranges.x), y: of(ranges.y), z: of(ranges.z), turn: of(ranges.turn) };
        let world = World::new(&SceneSpec { start: StartSpec::Block(block), ..shipped.clone() }, 0).unwrap();
        assert_eq!(world.particles().len(), shipped.particles);
    }
    assert_eq!(SceneSpec { start: spec().start, ..shipped }, spec(), "the tests measure what is shipped");
}
