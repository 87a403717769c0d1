//! Friction with a tangential spring: it holds what the regularised law lets creep, and slides as Coulomb says.
use super::*;
use glam::DQuat;
use pliant::state::Wall;

const RADIUS: f64 = 0.01;
const STIFFNESS: f64 = 5e4;
const MU: f64 = 0.5;
const SLIP: f64 = 0.02;
const GRAVITY: f64 = 9.81;
const SPRING: &str = "tangential_stiffness = 2e4";

fn touching(kind: &str, more: &str) -> String {
    format!(
        "[[laws]]\nkind = \"{kind}\"\nradius = {RADIUS}\nstiffness = {STIFFNESS}\ndamping = 1.0\nfriction = {MU}\nslip = {SLIP}\n{more}\n"
    )
}

fn built(rigid: &[u32], laws: &str) -> Box<dyn WorldModel> {
    let gravity = format!("[[laws]]\nkind = \"gravity\"\nacceleration = {GRAVITY}\n");
    let spec = format!("substeps = 400\nkeep = 1.0\nrigid = {rigid:?}\n{laws}{gravity}");
    ModelSpec::Particles(toml_edit::de::from_str(&spec).unwrap()).build().unwrap()
}

/// A slab of nine particles that lies, pressed in by its weight, on a plane of this slope far above the table, and the way down.
fn incline(slope: f64, steps: usize) -> (Scene, Vec<Control>, DVec3) {
    let turn = DQuat::from_rotation_y(slope);
    let (normal, down) = (turn * DVec3::Z, turn * DVec3::X);
    let sunk = (GRAVITY * slope.cos() / STIFFNESS).powf(2.0 / 3.0);
    let place = |n: usize| DVec3::new((n % 3) as f64 - 1.0, (n / 3) as f64 - 1.0, 0.0) * 0.03;
    let height = (1.0 + RADIUS - sunk) * normal;
    let particles = Particles::at_rest((0..9).map(|n| height + turn * place(n)).collect());
    let (mut start, controls) = alone(particles, steps);
    start.walls = [Wall { normal, offset: 1.0 }].into();
    (start, controls, down)
}

/// How far the slab has come down after each step, and how fast it is at the end.
fn descent(model: &dyn WorldModel, slope: f64, steps: usize) -> (Vec<f64>, f64) {
    let (start, controls, down) = incline(slope, steps);
    let rollout = model.rollout(&start, &controls);
    let middle = |rows: &[DVec3]| rows.iter().sum::<DVec3>().dot(down) / 9.0;
    let first = middle(&rollout[0].positions);
    (rollout.iter().map(|x| middle(&x.positions) - first).collect(), middle(&rollout[steps].velocities))
}

#[test]
fn below_the_friction_angle_a_block_stays_where_the_regularised_law_creeps() {
    let slope = 0.3_f64.atan();
    for rigid in [&[][..], &[0]] {
        let (way, speed) = descent(&*built(rigid, &touching("floor", SPRING)), slope, 20);
        let bent = GRAVITY * slope.sin() / 2e4;
        assert!((way[20] / bent - 1.0).abs() < 1e-6, "it rests where the spring bears its weight: {}", way[20]);
        assert!((way[20] - way[10]).abs() < 1e-12 && speed.abs() < 1e-12, "it creeps: {way:?}");
        // Drag bears the weight at the speed where v/√(v² + v_s²) = tan α/μ.
        let (way, speed) = descent(&*built(rigid, &touching("floor", "")), slope, 20);
        let creep = SLIP * 0.6 / (1.0_f64 - 0.36).sqrt();
        assert!((speed / creep - 1.0).abs() < 1e-3, "{speed} against {creep}");
        assert!(way[20] - way[10] > 0.9 * creep);
    }
}

#[test]
fn above_it_a_block_slides_as_coulomb_says() {
    let slope = 0.8_f64.atan();
    for rigid in [&[][..], &[0]] {
        for more in ["", SPRING] {
            let (way, speed) = descent(&*built(rigid, &touching("floor", more)), slope, 5);
            let pull = GRAVITY * (slope.sin() - MU * slope.cos());
            assert!((speed / (0.5 * pull) - 1.0).abs() < 0.02, "{more}: {speed} against {}", 0.5 * pull);
            assert!((way[5] / (0.125 * pull) - 1.0).abs() < 0.04, "{more}: {}", way[5]);
        }
    }
}

#[test]
fn a_particle_stays_on_its_place_of_a_plate_that_moves_and_turns() {
    let rides = |more: &str| {
        let particles = Particles::at_rest(vec![DVec3::new(0.02, 0.0, 0.0195)]);
        let start = scene(particles, vec![cuboid(0.2, 0.2, 0.01)], vec![Pose::default()]);
        let path = |t: f64| Pose {
            translation: DVec3::new(0.02 * t, 0.0, 0.0),
            rotation: DQuat::from_rotation_z(1.5 * t) * DQuat::from_rotation_y(0.1 * t),
        };
        let controls: Vec<_> = (1..=20).map(|t| Control { poses: vec![path(0.1 * f64::from(t))] }).collect();
        let rollout = built(&[], &touching("tool", more)).rollout(&start, &controls);
        let local = |t: usize| {
            let pose = path(0.1 * t as f64);
            pose.rotation.inverse() * (rollout[t].positions[0] - pose.translation)
        };
        local(20).truncate().distance(local(2).truncate())
    };
    // What is left is what the spring gives way to as the plate tilts.
    let (held, crept) = (rides(SPRING), rides(""));
    assert!(held < 2.0 * GRAVITY * 0.2 / 2e4, "{held}");
    assert!(crept > 5.0 * held, "the regularised law creeps on a tilted plate: {crept}");
}

#[test]
fn springs_between_particles_keep_momentum() {
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let positions: Vec<DVec3> = block().into_iter().map(|x| DVec3::Z + 1.7 * x).collect();
    let particles = Particles { velocities: positions.iter().map(|_| 0.2 * vector(&mut rng)).collect(), positions };
    let (start, controls) = alone(particles, 3);
    let contact = |more: &str| {
        let text = touching("contact", more).replace("[[laws]]\n", "");
        model(400, vec![law(&text)]).rollout(&start, &controls)
    };
    let (sprung, plain) = (contact(SPRING), contact(""));
    let momentum = |x: &Particles| x.velocities.iter().sum::<DVec3>();
    let speed: f64 = sprung[0].velocities.iter().map(|v| v.length()).sum();
    assert!(momentum(&sprung[0]).distance(momentum(&sprung[3])) < 1e-10 * speed);
    let apart = sprung[3].positions.iter().zip(&plain[3].positions).map(|(a, b)| a.distance(*b));
    assert!(apart.fold(0.0, f64::max) > 1e-4, "the spring does nothing");
}

#[test]
fn a_spring_is_forgotten_with_its_contact_and_never_longer_than_the_coulomb_limit() {
    let law = law(&touching("floor", SPRING).replace("[[laws]]\n", ""));
    let memory = law.remembers().expect("a spring remembers");
    let after = |history: &History, overlap: f64, speed: f64| {
        let positions = vec![DVec3::Z * (RADIUS - overlap)];
        let particles = Particles { positions, velocities: vec![DVec3::X * speed] };
        seen(&particles, history, |view| memory.advance(view, 1e-3))
    };
    let stretched = after(History::NONE, 1e-3, 0.01);
    assert_eq!(stretched.row::<3>(0), [1e-5, 0.0, 0.0], "what slid, times the time");
    let limit = MU * STIFFNESS * 1e-3_f64.powf(1.5) / 2e4;
    let longest = (0..1000).fold(stretched.clone(), |history, _| after(&history, 1e-3, 0.1));
    assert!((longest.row::<3>(0)[0] / limit - 1.0).abs() < 1e-12);
    let lifted = after(&longest, -1e-6, 0.1);
    assert_eq!(lifted.pairs().len(), 0);
    assert_eq!(after(&lifted, 1e-3, 0.01), stretched);
}
