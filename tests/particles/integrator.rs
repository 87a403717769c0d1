//! Properties of the integrator, whatever the laws.
use super::*;
use glam::DQuat;
use proptest::prelude::*;

const GRAVITY: &str = "kind = \"gravity\"\nacceleration = 9.81";

fn floor(friction: f64) -> Box<dyn Law> {
    law(&format!(
        "kind = \"floor\"\nradius = 0.01\nstiffness = 5e4\ndamping = 1.0\nfriction = {friction}\nslip = 0.001"
    ))
}

#[test]
fn free_fall_is_the_formula_of_semi_implicit_euler() {
    let (z, v, substeps, steps) = (1.0, DVec3::new(0.3, -0.1, 0.5), 7, 4);
    let particles = Particles { positions: vec![DVec3::Z * z], velocities: vec![v] };
    let (start, controls) = alone(particles, steps);
    let end = model(substeps, vec![law(GRAVITY)]).rollout(&start, &controls).pop().unwrap();
    let (n, h) = ((substeps * steps) as f64, 0.1 / substeps as f64);
    let expected = DVec3::Z * z + n * h * v - DVec3::Z * 9.81 * h * h * n * (n + 1.0) / 2.0;
    assert!(end.positions[0].distance(expected) < 1e-13);
    assert!(end.velocities[0].distance(v - DVec3::Z * 9.81 * n * h) < 1e-13);
}

#[test]
fn kept_velocity_does_not_depend_on_the_substep() {
    let particles = Particles { positions: vec![DVec3::Z], velocities: vec![DVec3::X] };
    let (start, controls) = alone(particles, 2);
    for substeps in [1, 3, 40] {
        let model = ParticleModel::new(substeps, 0.3, None, Vec::new()).unwrap();
        let end = model.rollout(&start, &controls).pop().unwrap();
        assert!(end.velocities[0].distance(0.09 * DVec3::X) < 1e-14);
    }
}

#[test]
fn the_error_is_of_first_order_in_the_substep() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let positions: Vec<DVec3> = block().into_iter().filter(|x| x.length() < 0.025).collect();
    let velocities = positions.iter().map(|_| 0.05 * vector(&mut rng)).collect();
    let start = scene(Particles { positions, velocities }, vec![cuboid(0.05, 0.05, 0.01)], vec![at(0.034)]);
    let controls = [Control { poses: vec![at(0.031)] }];
    let end = |substeps: usize| {
        let laws = analytic().laws.into_iter().map(|law| law.build().unwrap()).collect();
        model(substeps, laws).rollout(&start, &controls).pop().unwrap()
    };
    let truth = end(40 * 512);
    let errors: Vec<(f64, f64)> = [1, 2, 4, 8]
        .map(|n| {
            let far =
                end(40 * n).positions.iter().zip(&truth.positions).map(|(a, b)| a.distance_squared(*b)).sum::<f64>();
            ((1.0 / n as f64).ln(), far.sqrt().ln())
        })
        .to_vec();
    let mean = |of: fn(&(f64, f64)) -> f64| errors.iter().map(of).sum::<f64>() / errors.len() as f64;
    let (x, y) = (mean(|e| e.0), mean(|e| e.1));
    let slope = errors.iter().map(|e| (e.0 - x) * (e.1 - y)).sum::<f64>()
        / errors.iter().map(|e| (e.0 - x).powi(2)).sum::<f64>();
    assert!((slope - 1.0).abs() < 0.15, "order {slope} from {errors:?}");
}

#[test]
fn a_sliding_particle_stops_after_v_squared_over_two_mu_g() {
    let (friction, speed) = (0.3, 0.5);
    let sunk = (9.81_f64 / 5e4).powf(2.0 / 3.0);
    let particles = Particles { positions: vec![DVec3::Z * (0.01 - sunk)], velocities: vec![DVec3::X * speed] };
    let (start, controls) = alone(particles, 4);
    let end = model(400, vec![law(GRAVITY), floor(friction)]).rollout(&start, &controls).pop().unwrap();
    let expected = speed * speed / (2.0 * friction * 9.81);
    assert!((end.positions[0].x / expected - 1.0).abs() < 0.01, "{} against {expected}", end.positions[0].x);
    assert!(end.velocities[0].length() < 1e-6);
    assert!((end.positions[0].z - 0.01 + sunk).abs() < 1e-9, "it rests where its weight is carried");
}

#[test]
fn a_particle_rides_on_a_moving_tool() {
    // A plate that carries the particle sideways and turns under it: friction brings it to the surface's own velocity.
    let particles = Particles::at_rest(vec![DVec3::new(0.02, 0.0, 0.0195)]);
    let start = scene(particles, vec![cuboid(0.2, 0.2, 0.01)], vec![Pose::default()]);
    let path = |t: f64| Pose { translation: DVec3::X * 0.02 * t, rotation: DQuat::from_rotation_z(0.4 * t) };
    let controls: Vec<_> = (1..=20).map(|t| Control { poses: vec![path(0.1 * f64::from(t))] }).collect();
    let tool = law("kind = \"tool\"\nradius = 0.01\nstiffness = 5e4\ndamping = 1.0\nfriction = 0.9\nslip = 0.005");
    let rollout = model(400, vec![law(GRAVITY), tool]).rollout(&start, &controls);
    let (end, last) = (rollout.last().unwrap(), path(2.0));
    let surface = DVec3::X * 0.02 + DVec3::Z.cross(end.positions[0] - last.translation) * 0.4;
    assert!(end.velocities[0].truncate().distance(surface.truncate()) < 1e-4, "{} {surface}", end.velocities[0]);
    assert!((end.positions[0].z - 0.02).abs() < 0.005);
}

#[test]
fn the_only_substep_sees_the_tool_where_it_arrives() {
    let start = scene(Particles::at_rest(vec![DVec3::ZERO]), vec![cuboid(0.01, 0.01, 0.01)], vec![at(0.1)]);
    let tool = "kind = \"tool\"\nradius = 0.01\nstiffness = 1.0\ndamping = 0.0\nfriction = 0.0\nslip = 0.001";
    let moved = |z: f64| model(1, vec![law(tool)]).rollout(&start, &[Control { poses: vec![at(z)] }]).pop().unwrap();
    assert_eq!(moved(0.021).positions[0], DVec3::ZERO);
    let expected = -0.1 * 0.1 * 0.004_f64.powf(1.5);
    assert!((moved(0.016).positions[0].z - expected).abs() < 1e-12);
}

pub(super) fn random_motion(seed: u64, steps: usize) -> (Scene, Vec<Control>) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let parts = vec![
        cuboid(0.01, 0.03, 0.02),
        Part { solid: Solid::Cylinder { radius: 0.015, half_length: 0.04 }, surface: Vec::new() },
    ];
    let mut pose = |height: f64| Pose {
        translation: 0.03 * vector(&mut rng) + DVec3::Z * height,
        rotation: DQuat::from_scaled_axis(1.5 * vector(&mut rng)),
    };
    let start = vec![pose(0.08), pose(0.08)];
    let (middle, end) = (vec![pose(0.02), pose(0.02)], vec![pose(0.06), pose(0.06)]);
    let path = |t: usize| {
        let s = 2.0 * t as f64 / steps as f64;
        let (from, to, s) = if s <= 1.0 { (&start, &middle, s) } else { (&middle, &end, s - 1.0) };
        Control { poses: from.iter().zip(to).map(|(a, b)| a.toward(b, s)).collect() }
    };
    let controls = (1..=steps).map(path).collect();
    (scene(Particles::at_rest(block()), parts, start), controls)
}

#[test]
fn rollouts_are_finite_under_random_motions_and_the_same_one_by_one() {
    let model = analytic_model();
    let problems: Vec<_> = (0..6).map(|seed| random_motion(seed, 6)).collect();
    let start = &problems[0].0;
    let candidates: Vec<_> = problems.iter().map(|(_, controls)| controls.clone()).collect();
    let motions: Vec<_> =
        candidates.iter().map(|c| Motion { start: start.poses.clone(), controls: c.clone() }).collect();
    let together = model.rollouts(start, &motions);
    for (controls, rollout) in candidates.iter().zip(&together) {
        assert!(rollout.iter().all(Particles::is_finite));
        assert_eq!(&model.rollout(start, controls), rollout);
    }
    assert_ne!(together[0], together[1]);
}

/// A rollout of random motion whose particles are given another order afterwards, and one whose particles have it from the start.
pub(crate) fn relabelled(model: &dyn WorldModel, order: &[usize], seed: u64) -> [Vec<Particles>; 2] {
    let (start, controls) = random_motion(seed, 3);
    let shuffle = |x: &Particles| Particles {
        positions: order.iter().map(|&i| x.positions[i]).collect(),
        velocities: order.iter().map(|&i| x.velocities[i]).collect(),
    };
    let other = Scene { particles: shuffle(&start.particles), ..start.clone() };
    let rollout = model.rollout(&start, &controls);
    [rollout.iter().map(shuffle).collect(), model.rollout(&other, &controls)]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    #[test]
    fn relabelling_particles_relabels_the_rollout_bit_for_bit(
        order in Just((0..120).collect::<Vec<usize>>()).prop_shuffle(), seed in 0u64..1000,
    ) {
        let model = analytic_model();
        let [rollout, relabelled] = relabelled(&*model, &order, seed);
        for (x, y) in rollout.iter().zip(&relabelled) {
            prop_assert_eq!(x, y);
        }
    }
}
