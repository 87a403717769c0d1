//! Velocity Verlet: exact in free fall, reversible, of second order with and without damping, and gentle with energy.
use super::*;

const SPRING: &str = "kind = \"formula\"\nname = \"spring\"\nbetween = \"particles\"\nreach = 0.1\nenergy = \"k/2 * (r - rest)^2\"\nconstants = { k = 40.0, rest = 0.01 }\n";
const VISCOSITY: &str = "kind = \"viscosity\"\nrate = 3.0\nreach = 0.1\n";
const GRAVITY: &str = "kind = \"gravity\"\nacceleration = 9.81\n";

fn moved_by(integrator: &str, substeps: usize, keep: f64, laws: &[&str]) -> Box<dyn WorldModel> {
    let laws: String = laws.iter().map(|law| format!("[[laws]]\n{law}")).collect();
    let text = format!("substeps = {substeps}\nkeep = {keep}\nintegrator = \"{integrator}\"\n{laws}");
    ModelSpec::Particles(toml_edit::de::from_str(&text).unwrap()).build().unwrap()
}

/// Four particles that swing about each other on springs.
fn swinging() -> Particles {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let corners = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
    let positions: Vec<_> = corners.map(|x| DVec3::Z + 0.004 * DVec3::from_array(x)).into();
    Particles { velocities: positions.iter().map(|_| 0.02 * vector(&mut rng)).collect(), positions }
}

/// Kinetic and elastic energy per unit mass.
fn energy(x: &Particles) -> f64 {
    let pairs = (0..4).flat_map(|i| (0..i).map(move |j| x.positions[i].distance(x.positions[j]) - 0.01));
    20.0 * pairs.map(|stretch| stretch * stretch).sum::<f64>()
        + 0.5 * x.velocities.iter().map(|v| v.length_squared()).sum::<f64>()
}

/// The slope of the logarithm of the error over that of the substep.
fn order((start, controls): &(Scene, Vec<Control>), integrator: &str, keep: f64, laws: &[&str]) -> f64 {
    let end = |substeps| moved_by(integrator, substeps, keep, laws).rollout(start, controls).pop().unwrap();
    let truth = end(4096);
    let points: Vec<(f64, f64)> = [8, 16, 32, 64]
        .map(|substeps| {
            let x = end(substeps);
            let far = |a: &[DVec3], b: &[DVec3]| a.iter().zip(b).map(|(a, b)| a.distance_squared(*b)).sum::<f64>();
            let error = far(&x.positions, &truth.positions) + 0.01 * far(&x.velocities, &truth.velocities);
            ((substeps as f64).recip().ln(), 0.5 * error.ln())
        })
        .to_vec();
    let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / 4.0;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum::<f64>() / points.iter().map(|p| (p.0 - x).powi(2)).sum::<f64>()
}

#[test]
fn free_fall_is_the_parabola() {
    let particles = Particles { positions: vec![DVec3::Z], velocities: vec![DVec3::new(0.3, -0.1, 0.5)] };
    let (start, controls) = alone(particles, 4);
    let end = moved_by("velocity_verlet", 7, 1.0, &[GRAVITY]).rollout(&start, &controls).pop().unwrap();
    let t = 0.4;
    let expected = DVec3::Z + t * DVec3::new(0.3, -0.1, 0.5) - 0.5 * 9.81 * t * t * DVec3::Z;
    assert!(end.positions[0].distance(expected) < 1e-13);
    assert!((end.velocities[0].z - 0.5 + 9.81 * t).abs() < 1e-13);
}

#[test]
fn it_is_of_second_order_with_damping_and_without() {
    for (keep, laws) in [(1.0, &[SPRING][..]), (1.0, &[SPRING, VISCOSITY]), (0.3, &[SPRING, VISCOSITY, GRAVITY])] {
        let moment = alone(swinging(), 5);
        let slope = order(&moment, "velocity_verlet", keep, laws);
        assert!((slope - 2.0).abs() < 0.15, "order {slope} of {laws:?} with keep {keep}");
        let first = order(&moment, "semi_implicit_euler", keep, laws);
        assert!((first - 1.0).abs() < 0.15, "order {first} of semi-implicit Euler");
    }
}

/// Were the tool a substep before or behind its place, the error would be of first order.
#[test]
fn it_is_of_second_order_under_a_plate_that_comes_down() {
    let particle = Particles { positions: vec![DVec3::new(0.0, 0.0, 0.075)], velocities: vec![DVec3::ZERO] };
    let start = scene(particle, vec![cuboid(0.05, 0.05, 0.01)], vec![at(0.1)]);
    let controls = (1..=5).map(|t| Control { poses: vec![at(0.1 - 0.002 * f64::from(t))] }).collect();
    let plate = "kind = \"tool\"\nradius = 0.02\nstiffness = 100.0\ndamping = 2.0\nfriction = 0.0\nslip = 0.02\n";
    let slope = order(&(start, controls), "velocity_verlet", 0.8, &[plate]);
    assert!((slope - 2.0).abs() < 0.15, "order {slope}");
}

#[test]
fn what_turns_round_comes_back() {
    let (start, controls) = alone(swinging(), 5);
    let model = moved_by("velocity_verlet", 20, 1.0, &[SPRING, GRAVITY]);
    let mut there = model.rollout(&start, &controls).pop().unwrap();
    let away = there.positions.iter().zip(&start.particles.positions).map(|(a, b)| a.distance(*b));
    assert!(away.fold(0.0, f64::max) > 0.01, "nothing moved");
    there.velocities.iter_mut().for_each(|v| *v = -*v);
    let back = model.rollout(&Scene { particles: there, ..start.clone() }, &controls).pop().unwrap();
    for (a, b) in back.positions.iter().zip(&start.particles.positions) {
        assert!(a.distance(*b) < 1e-12);
    }
}

#[test]
fn energy_swings_with_the_square_of_the_substep_and_does_not_drift() {
    let (start, controls) = alone(swinging(), 1000);
    let swing = |integrator: &str, substeps: usize| -> Vec<f64> {
        let rollout = moved_by(integrator, substeps, 1.0, &[SPRING]).rollout(&start, &controls);
        let first = energy(&rollout[0]);
        rollout.iter().map(|x| (energy(x) - first).abs() / first).collect()
    };
    let most = |swings: &[f64]| swings.iter().copied().fold(0.0, f64::max);
    let (coarse, fine) = (swing("velocity_verlet", 10), swing("velocity_verlet", 20));
    // 10⁴ and 2 10⁴ substeps.
    assert!(most(&coarse) < 0.01, "{}", most(&coarse));
    assert!(
        most(&coarse[500..]) < 1.5 * most(&coarse[..500]),
        "energy drifts: {} then {}",
        most(&coarse[..500]),
        most(&coarse[500..])
    );
    let ratio = coarse.iter().sum::<f64>() / fine.iter().sum::<f64>();
    assert!((3.4..4.6).contains(&ratio), "second order: {ratio}");
    assert!(most(&swing("semi_implicit_euler", 10)) > 4.0 * most(&coarse));
}

#[test]
fn what_it_cannot_move_is_refused_and_the_default_is_left_unsaid() {
    let refused = |text: &str| {
        let spec: ParticlesSpec = toml_edit::de::from_str(text).unwrap();
        ModelSpec::Particles(spec).build().err().expect("an impossible config").to_string()
    };
    let verlet = "substeps = 4\nintegrator = \"velocity_verlet\"\n";
    assert!(refused(&format!("{verlet}keep = 0.5\nrigid = [1]")).contains("dynamics.rigid"));
    assert!(refused(&format!("{verlet}keep = 0.0")).contains("dynamics.keep"));
    let said = toml_edit::ser::to_string(&ModelSpec::Particles(analytic())).unwrap();
    assert!(!said.contains("integrator"), "fingerprints of older configs change");
}
