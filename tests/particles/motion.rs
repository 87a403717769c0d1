//! What the laws between particles must conserve.
use super::*;

const CONTACT: &str = "kind = \"contact\"\nradius = 0.0043\nstiffness = 5e4\ndamping = 2.0\nslip = 0.02\nfriction = ";
const COHESION: &str = "kind = \"cohesion\"\nstrength = 2.0\ncontact = 0.0086\nreach = 0.012";
const VISCOSITY: &str = "kind = \"viscosity\"\nrate = 60.0\nreach = 0.012";

/// (linear, angular) momentum per unit mass.
fn momenta(particles: &Particles) -> (DVec3, DVec3) {
    let rows = particles.positions.iter().zip(&particles.velocities);
    rows.fold((DVec3::ZERO, DVec3::ZERO), |(p, l), (x, v)| (p + *v, l + x.cross(*v)))
}

fn moving() -> Particles {
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let positions = block();
    Particles { velocities: positions.iter().map(|_| 0.1 * vector(&mut rng)).collect(), positions }
}

fn change(laws: Vec<Box<dyn Law>>) -> (f64, f64, f64) {
    let (start, controls) = alone(moving(), 3);
    let rollout = model(40, laws).rollout(&start, &controls);
    let speed: f64 = rollout[0].velocities.iter().map(|v| v.length()).sum();
    let turn: f64 = rollout[0].positions.iter().zip(&rollout[0].velocities).map(|(x, v)| x.length() * v.length()).sum();
    let [(p0, l0), (p1, l1)] = [momenta(&rollout[0]), momenta(&rollout[3])];
    let moved: f64 = rollout[0].velocities.iter().zip(&rollout[3].velocities).map(|(a, b)| a.distance(*b)).sum();
    (p0.distance(p1) / speed, l0.distance(l1) / turn, moved / speed)
}

#[test]
fn laws_between_particles_keep_linear_momentum() {
    for text in [&format!("{CONTACT}0.5"), COHESION, VISCOSITY] {
        let (linear, _, moved) = change(vec![law(text)]);
        assert!(moved > 0.01, "{text} does nothing here");
        assert!(linear < 1e-12, "{text}: linear momentum changed by {linear}");
    }
}

#[test]
fn central_laws_keep_angular_momentum_and_friction_without_spin_does_not() {
    for text in [&format!("{CONTACT}0.0"), COHESION, VISCOSITY] {
        let (_, angular, _) = change(vec![law(text)]);
        assert!(angular < 1e-12, "{text}: angular momentum changed by {angular}");
    }
    let (_, angular, _) = change(vec![law(&format!("{CONTACT}0.5"))]);
    assert!(
        angular > 1e-6,
        "friction at the middle of a contact turns both particles, which have no spin to take it up"
    );
}

#[test]
fn contact_is_the_formula() {
    // Two particles overlapping by 1 mm, parting at 0.1 m/s and sliding at 0.2 m/s.
    let velocities = vec![DVec3::ZERO, DVec3::new(0.1, 0.2, 0.0)];
    let particles = Particles { positions: vec![DVec3::ZERO, DVec3::X * 0.0076], velocities };
    let (start, controls) = alone(particles, 1);
    let h = 1e-9;
    let start = Scene { interval: h, ..start };
    let end = model(1, vec![law(&format!("{CONTACT}0.5"))]).rollout(&start, &controls).pop().unwrap();
    let push = 5e4 * 0.001_f64.powf(1.5) * (1.0 - 2.0 * 0.1);
    let expected = DVec3::new(push, -0.5 * push * 0.2 / (0.2_f64 * 0.2 + 0.02 * 0.02).sqrt(), 0.0);
    let found = (end.velocities[1] - start.particles.velocities[1]) / h;
    assert!(found.distance(expected) < 1e-5 * expected.length(), "{found} against {expected}");
}

#[test]
fn laws_that_dissipate_never_add_energy() {
    let energy = |x: &Particles| x.velocities.iter().map(|v| v.length_squared()).sum::<f64>();
    let (start, controls) = alone(moving(), 3);
    let rollout = model(40, vec![law(VISCOSITY)]).rollout(&start, &controls);
    assert!(rollout.windows(2).all(|w| energy(&w[1]) < energy(&w[0])));
}
