//! Bodies that keep their shape: exactly rigid, moved as Newton says, and apart from those that flow.
use super::*;
use glam::DQuat;

/// A tilted cube of 27 particles, 1 cm apart, around `at`.
fn cube(at: DVec3) -> Vec<DVec3> {
    let turn = DQuat::from_scaled_axis(DVec3::new(0.5, 0.3, 0.2));
    let place = |n: usize| DVec3::new((n % 3) as f64 - 1.0, (n / 3 % 3) as f64 - 1.0, (n / 9) as f64 - 1.0);
    (0..27).map(|n| at + turn * (0.01 * place(n))).collect()
}

/// Two cubes and a lump of 40 loose particles, in a shuffled order, and their bodies: 1, 2 and 0.
fn heap() -> (Particles, Vec<u32>) {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let loose = (0..40).map(|_| DVec3::Z * 0.05 + 0.02 * vector(&mut rng));
    let lists = [loose.collect(), cube(DVec3::new(0.03, 0.0, 0.03)), cube(DVec3::new(-0.03, 0.01, 0.04))];
    let rows = lists.into_iter().enumerate();
    let rows: Vec<(u32, DVec3)> = rows.flat_map(|(k, list)| list.into_iter().map(move |x| (k as u32, x))).collect();
    let shuffled: Vec<(u32, DVec3)> = (0..rows.len()).map(|i| rows[i * 41 % rows.len()]).collect();
    let (body, positions) = shuffled.into_iter().unzip();
    (Particles::at_rest(positions), body)
}

fn rigid(substeps: usize, bodies: &[u32], laws: &str) -> Box<dyn WorldModel> {
    let spec = format!("substeps = {substeps}\nkeep = 1.0\nrigid = {bodies:?}\n{laws}");
    ModelSpec::Particles(toml_edit::de::from_str(&spec).unwrap()).build().unwrap()
}

const GRAVITY: &str = "[[laws]]\nkind = \"gravity\"\nacceleration = 9.81\n";
const FLOOR: &str =
    "[[laws]]\nkind = \"floor\"\nradius = 0.006\nstiffness = 1e6\ndamping = 3.0\nslip = 0.02\nfriction = 0.5\n";
const CONTACT: &str =
    "[[laws]]\nkind = \"contact\"\nradius = 0.0043\nstiffness = 2e4\ndamping = 2.0\nslip = 0.02\nfriction = 0.3\n";

/// The greatest change of a distance inside the body of this number between two states \[m\].
fn strain(body: &[u32], number: u32, a: &Particles, b: &Particles) -> f64 {
    let rows: Vec<usize> = (0..body.len()).filter(|&i| body[i] == number).collect();
    let gap = |x: &Particles, i: usize, j: usize| x.positions[i].distance(x.positions[j]);
    let pairs = rows.iter().flat_map(|&i| rows.iter().map(move |&j| (i, j)));
    pairs.map(|(i, j)| (gap(a, i, j) - gap(b, i, j)).abs()).fold(0.0, f64::max)
}

#[test]
fn distances_inside_a_rigid_body_never_change_and_others_do() {
    let (particles, body) = heap();
    let (mut start, controls) = alone(particles, 20);
    start.body = body.clone().into();
    let rollout = rigid(200, &[1, 2], &[GRAVITY, FLOOR, CONTACT].concat()).rollout(&start, &controls);
    let last = rollout.last().unwrap();
    assert!(last.is_finite());
    for number in [1, 2] {
        assert!(strain(&body, number, &rollout[0], last) < 1e-12);
    }
    assert!(strain(&body, 0, &rollout[0], last) > 1e-3, "loose particles stay where they are");
    let resting = last.velocities.iter().zip(&body).filter(|(_, b)| **b > 0).map(|(v, _)| v.length());
    assert!(resting.fold(0.0, f64::max) < 0.02, "cubes come to rest on the table");
    // One corner bears a whole cube, so that it sinks deeper than a particle would.
    assert!(last.positions.iter().all(|x| x.z > -0.004));
}

#[test]
fn a_rigid_body_falls_as_a_point_does_and_pushes_keep_momentum() {
    let (start, controls) = alone(Particles::at_rest(cube(DVec3::Z)), 3);
    let rollout = rigid(10, &[0], GRAVITY).rollout(&start, &controls);
    for (x, y) in rollout[0].positions.iter().zip(&rollout[3].positions) {
        // Semi-implicit Euler: n steps of h fall by g h² n (n + 1)/2.
        let fallen = 9.81 * 1e-4 * (30.0 * 31.0) / 2.0;
        assert!((x.z - y.z - fallen).abs() < 1e-12 && x.truncate().distance(y.truncate()) < 1e-12);
    }

    let (mut particles, body) = heap();
    let speed = |b: u32| DVec3::new(0.1 * f64::from(b), -0.05, 0.02);
    particles.velocities = body.iter().map(|b| speed(*b)).collect();
    let (mut start, controls) = alone(particles, 5);
    start.body = body.into();
    let rollout = rigid(40, &[1, 2], CONTACT).rollout(&start, &controls);
    let sum = |x: &Particles| x.velocities.iter().sum::<DVec3>();
    let moved: f64 = rollout[0].velocities.iter().zip(&rollout[5].velocities).map(|(a, b)| a.distance(*b)).sum();
    assert!(moved > 0.1, "nothing met");
    assert!(sum(&rollout[0]).distance(sum(&rollout[5])) < 1e-10 * moved);
}

#[test]
fn a_free_body_spins_on_the_more_evenly_the_finer_the_steps() {
    let spin = DVec3::new(0.0, 0.0, 3.0);
    let mut particles = Particles::at_rest(cube(DVec3::Z));
    particles.velocities = particles.positions.iter().map(|x| spin.cross(*x - DVec3::Z)).collect();
    let (start, controls) = alone(particles, 5);
    let lost = |substeps: usize| {
        let rollout = rigid(substeps, &[0], "").rollout(&start, &controls);
        let [from, to] = [0, 5].map(|t| rollout[t].positions[0] - DVec3::Z);
        let turned = from.truncate().angle_to(to.truncate());
        spin.z * 0.5 - turned
    };
    let losses = [20, 40, 80].map(lost);
    assert!(losses[2] > 0.0 && losses[2] < 0.01, "{losses:?}");
    for pair in losses.windows(2) {
        assert!((1.8..2.2).contains(&(pair[0] / pair[1])), "first order: {losses:?}");
    }
}

#[test]
fn a_particle_of_its_own_and_a_body_that_is_not_there_are_no_trouble() {
    let (mut start, controls) = alone(Particles::at_rest(vec![DVec3::Z, DVec3::new(0.1, 0.0, 1.0)]), 2);
    start.body = [3, 0].into();
    let bound = rigid(4, &[3, 7], GRAVITY).rollout(&start, &controls);
    let free = rigid(4, &[], GRAVITY).rollout(&start, &controls);
    for (a, b) in bound[2].positions.iter().zip(&free[2].positions) {
        assert!(a.distance(*b) < 1e-14);
    }
}
