//! Grains and rigid pieces, where physics says exactly what they do.
use crate::bench::*;
use glam::{DVec2, DVec3};
use pliant::state::{Control, Snapshot};
use pliant::world::{
    BlockSpec, GrainSpec, GrainsSpec, MaterialSpec, RigidSpec, SceneSpec, SolverSpec, StartSpec, World,
};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

fn finely(material: MaterialSpec, particles: usize) -> SceneSpec {
    let solver = SolverSpec { steps: 20, substeps: 4, sweeps: 2 };
    SceneSpec { material, particles, interval: 0.05, solver, ..spec() }
}

fn rigid(friction: f64, restitution: f64) -> SceneSpec {
    finely(MaterialSpec::Rigid(RigidSpec { density: 800.0, friction, restitution }), 8)
}

fn grains(grain: GrainSpec, count: usize, friction: f64) -> SceneSpec {
    finely(MaterialSpec::Grains(GrainsSpec { grain, density: 1100.0, friction, restitution: 0.1, rolling: 0.0 }), count)
}

/// What the scene is made of, filling a box in the middle of the table, `raised` above it and not yet settled.
fn dropped(spec: &SceneSpec, half: DVec3, raised: f64) -> World {
    standing(spec, 2.0 * half, DVec2::ZERO, raised)
}

fn lowest(points: &[DVec3]) -> f64 {
    points.iter().map(|p| p.z).fold(f64::INFINITY, f64::min)
}

#[test]
fn before_it_lands_every_material_falls_as_everything_falls() {
    let ball = GrainSpec::Ball { radius: [0.004, 0.006] };
    for spec in [
        SceneSpec { interval: 0.05, solver: SolverSpec { steps: 20, ..spec().solver }, ..spec() },
        rigid(0.5, 0.0),
        grains(ball, 30, 0.5),
    ] {
        let mut world = dropped(&spec, DVec3::new(0.03, 0.03, 0.015), 0.5);
        let start = world.all_positions();
        for i in 1..=5 {
            world.step(&Control::default());
            let time = f64::from(i) * spec.interval;
            let fall = 0.5 * GRAVITY * time * time;
            // Semi-implicit Euler falls g t dt/2 too far.
            let ahead = GRAVITY * time * spec.interval / (2.0 * (spec.solver.steps * spec.solver.substeps) as f64);
            for (now, then) in world.all_positions().iter().zip(&start) {
                let error = (*now - *then + DVec3::Z * fall).length();
                assert!(error <= 1.02 * ahead + 1e-5, "{error} m off after {time} s, {ahead} expected");
            }
        }
    }
}

#[test]
fn a_puck_slides_as_far_as_its_friction_lets_it() {
    // v²/(2 μ g): a half of the friction lets it go twice as far.
    for friction in [0.2, 0.4] {
        let mut world = dropped(&rigid(friction, 0.0), DVec3::new(0.03, 0.03, 0.005), 0.0);
        (0..10).for_each(|_| world.step(&Control::default()));
        let start = middle(&world.all_positions());
        world.kick(DVec3::X);
        (0..40).for_each(|_| world.step(&Control::default()));
        let slid = middle(&world.all_positions()) - start;
        let expected = 1.0 / (2.0 * friction * GRAVITY);
        assert!((slid.x / expected - 1.0).abs() < 0.02, "slid {slid} with μ = {friction}, {expected} expected");
        assert!(slid.y.abs() < 1e-3 * expected);
    }
}

#[test]
fn a_rolling_ball_slows_down_as_its_spin_is_damped() {
    // m v' = −F and (2/5) m r² ω' = F r − rate (2/5) m r² ω with v = ω r: v' = −(2/7) rate v.
    let grain = GrainSpec::Ball { radius: [0.01; 2] };
    for rolling in [0.0, 3.0, 7.0] {
        let material = GrainsSpec { grain: grain.clone(), density: 1000.0, friction: 0.8, restitution: 0.0, rolling };
        let mut world = dropped(&finely(MaterialSpec::Grains(material), 1), DVec3::splat(0.0105), 0.0);
        (0..10).for_each(|_| world.step(&Control::default()));
        world.kick(0.5 * DVec3::X);
        (0..6).for_each(|_| world.step(&Control::default()));
        let mut speed = |steps: usize| {
            (0..steps).for_each(|_| world.step(&Control::default()));
            world.particles().velocities[0].x
        };
        let (early, late) = (speed(1), speed(10));
        let expected = (-2.0 / 7.0 * rolling * 10.0 * 0.05).exp();
        assert!((late / early - expected).abs() < 0.02, "{early} to {late} m/s: {expected} expected of rate {rolling}");
    }
}

#[test]
fn a_body_pressed_onto_the_table_is_not_driven_through_it() {
    let wood = rigid(0.4, 0.0);
    let ball = grains(GrainSpec::Ball { radius: [0.008; 2] }, 1, 0.4);
    for spec in [wood, ball] {
        let mut world = dropped(&spec, DVec3::new(0.02, 0.02, 0.0105), 0.0);
        (0..10).for_each(|_| world.step(&Control::default()));
        let rest = lowest(&world.all_positions());
        let press = |height: f64| vec![at(0.0, 0.0, height + 0.01)];
        world.take(&plate(), &press(0.03));
        for step in 1..=20 {
            world.step(&Control { poses: press(0.03 - 0.029 * f64::from(step) / 20.0) });
            let now = lowest(&world.all_positions());
            assert!(now > rest - 3e-4, "{} mm lower than at rest", 1e3 * (rest - now));
        }
    }
}

#[test]
fn a_ball_bounces_to_the_square_of_its_restitution() {
    let ball = GrainSpec::Ball { radius: [0.01; 2] };
    for restitution in [0.0, 0.5, 0.8] {
        let material = GrainsSpec { grain: ball.clone(), density: 1000.0, friction: 0.5, restitution, rolling: 0.0 };
        let spec = SceneSpec { interval: 0.005, ..finely(MaterialSpec::Grains(material), 1) };
        let mut world = dropped(&spec, DVec3::splat(0.0105), 0.2);
        let height = |world: &World| world.all_positions()[0].z - 0.01;
        let fallen = height(&world);
        // The table's restitution is zero, and the engine takes the mean of the two.
        let effective = restitution / 2.0;
        let landing = (2.0 * fallen / GRAVITY).sqrt();
        let (mut highest, mut time) = (0.0f64, 0.0);
        while time < 2.5 * landing {
            world.step(&Control::default());
            time += spec.interval;
            if time > 1.05 * landing {
                highest = highest.max(height(&world));
            }
        }
        let expected = effective * effective * fallen;
        assert!((highest - expected).abs() < 0.03 * fallen, "rose to {highest} from {fallen}, {expected} expected");
    }
}

#[test]
fn without_friction_collisions_keep_the_momentum_along_the_table() {
    let mut world =
        dropped(&grains(GrainSpec::Ball { radius: [0.005; 2] }, 60, 0.0), DVec3::new(0.03, 0.03, 0.03), 0.0);
    world.kick(DVec3::new(0.3, -0.1, 0.0));
    let mean = |world: &World| world.particles().velocities.iter().sum::<DVec3>() / 60.0;
    for _ in 0..10 {
        world.step(&Control::default());
        // The pile collapses: single grains go anywhere, all together only on.
        assert!((mean(&world).truncate() - glam::DVec2::new(0.3, -0.1)).length() < 2e-3, "{}", mean(&world));
    }
    let fastest = world.particles().velocities.iter().map(|v| (*v - mean(&world)).length()).fold(0.0, f64::max);
    assert!(fastest > 0.05, "no grain was pushed aside");
}

#[test]
fn a_pile_is_steeper_the_rougher_its_grains() {
    let slope = |friction: f64| {
        let spec = grains(GrainSpec::Ball { radius: [0.003, 0.004] }, 150, friction);
        let start = StartSpec::Block(BlockSpec { x: [0.03; 2], y: [0.03; 2], z: [0.03; 2], turn: [0.0; 2] });
        let all = World::new(&SceneSpec { start, ..spec }, 2).unwrap().all_positions();
        let wide = all.iter().map(|p| (*p - middle(&all)).truncate().length_squared()).sum::<f64>() / all.len() as f64;
        top(&all) / wide.sqrt()
    };
    let slopes: Vec<f64> = [0.05, 0.3, 0.8].into_par_iter().map(slope).collect();
    assert!(slopes.windows(2).all(|s| s[1] > 1.1 * s[0]), "height over width {slopes:?}");
}

#[test]
fn a_shaken_tower_of_every_grain_loses_energy_and_no_grain() {
    let shapes = [
        GrainSpec::Ball { radius: [0.004, 0.006] },
        GrainSpec::Capsule { radius: [0.003; 2], half_length: [0.004, 0.006] },
        GrainSpec::Cuboid { half: [[0.004, 0.006], [0.004, 0.006], [0.003, 0.004]] },
        GrainSpec::Hull { radius: [0.005, 0.007], corners: 12 },
    ];
    shapes.into_par_iter().for_each(|shape| {
        let mut world = dropped(&grains(shape.clone(), 60, 0.4), DVec3::new(0.025, 0.025, 0.02), 0.01);
        world.kick(DVec3::new(0.2, 0.1, 0.0));
        // Kinetic and potential energy of the grains' middles, each of about equal mass.
        let energy = |world: &World| {
            let particles = world.particles();
            let each = particles.positions.iter().zip(&particles.velocities);
            each.map(|(x, v)| GRAVITY * x.z + 0.5 * v.length_squared()).sum::<f64>() / 60.0
        };
        let mut before = f64::INFINITY;
        for step in 0..40 {
            world.step(&Control::default());
            let now = energy(&world);
            // The velocity is a mean over the step, a hair behind the position.
            assert!(
                now < before + 0.02 * GRAVITY * 0.02,
                "{shape:?}: energy rose from {before} to {now} in step {step}"
            );
            before = now;
        }
        let all = world.all_positions();
        assert!(lowest(&all) > 0.0015, "{shape:?}: a grain at height {}", lowest(&all));
        // Balls roll on without end, but no faster than the height they fell from lets them.
        assert!(all.iter().all(|p| p.truncate().length() < 2.0), "{shape:?}: a grain was thrown off");
    });
}

#[test]
fn grains_continue_from_a_snapshot_byte_for_byte_whatever_the_thread_count() {
    let spec = grains(GrainSpec::Hull { radius: [0.005, 0.007], corners: 10 }, 40, 0.5);
    let run = |threads: usize| -> Vec<Snapshot> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let one = |seed: u64| {
            let world = World::new(&spec, seed).unwrap();
            let tool = shipped_tool("pusher");
            let motion = random_motion(&world, tool.as_ref(), &mut ChaCha8Rng::seed_from_u64(seed));
            let (mut going_on, mut restored) = (world.clone(), world);
            going_on.take(tool.shape(), &motion.start);
            restored.take(tool.shape(), &motion.start);
            for control in &motion.controls {
                going_on.step(control);
                restored = World::restore(&restored.snapshot()).unwrap();
                restored.step(control);
                assert!(going_on.snapshot() == restored.snapshot(), "seed {seed}: a restored world goes another way");
            }
            going_on.snapshot()
        };
        pool.install(|| (0..3u64).into_par_iter().map(one).collect())
    };
    let serial = run(1);
    assert!(serial == run(2), "two threads give other bytes");
    assert!(serial[0] != serial[1], "seeds differ");
}

#[test]
fn a_pusher_moves_the_pile_the_way_it_goes() {
    let spec = grains(GrainSpec::Cuboid { half: [[0.004, 0.006], [0.004, 0.006], [0.003, 0.004]] }, 60, 0.4);
    let mut world = World::new(&spec, 4).unwrap();
    let before = middle(&world.all_positions());
    let tool = shipped_tool("pusher");
    let piece = pliant::tool::Workpiece::around(&world.particles());
    // The deepest push: single grains lie far from the pile and stretch its box.
    let motion = tool.motion(&[0.0, 0.5, tool.space(&piece).high[2]], &piece, 15);
    world.execute(tool.shape(), &motion);
    let moved = middle(&world.all_positions()) - before;
    let along = DVec3::new(0.5f64.cos(), 0.5f64.sin(), 0.0);
    assert!(moved.dot(along) > 0.002, "the pile moved by {moved}");
    assert!(
        (moved - moved.dot(along) * along).truncate().length() < 0.5 * moved.dot(along),
        "the pile moved by {moved}"
    );
}

#[test]
fn a_rigid_piece_keeps_its_shape_when_it_is_pushed() {
    let start = StartSpec::Block(BlockSpec { x: [0.06; 2], y: [0.05; 2], z: [0.03; 2], turn: [0.3; 2] });
    let spec = SceneSpec { start, particles: 60, ..rigid(0.4, 0.0) };
    let mut world = World::new(&spec, 1).unwrap();
    let before = world.all_positions();
    let tool = shipped_tool("pusher");
    let motion = random_motion(&world, tool.as_ref(), &mut ChaCha8Rng::seed_from_u64(8));
    world.execute(tool.shape(), &motion);
    let after = world.all_positions();
    assert!(middle(&after).distance(middle(&before)) > 0.003, "nothing was pushed");
    for i in 0..before.len() {
        let change = before[i].distance(before[0]) - after[i].distance(after[0]);
        assert!(change.abs() < 1e-6, "a distance changed by {change} m");
    }
    assert!((world.volume() / 9e-5 - 1.0).abs() < 1e-4, "a volume of {} m³", world.volume());
}
