//! Formulas of every kind, over everything that a particle meets.
use super::*;

/// Laws of every kind of formula, over what they meet.
const KINDS: [(&str, &str); 9] = [
    (
        "a linear contact",
        "between = \"particles\"\nreach = 0.016\nnormal_force = \"k * overlap - c * vn\"\nconstants = { k = 50.0, c = 3.0 }",
    ),
    (
        "Hertz by energy",
        "between = \"particles\"\nreach = 0.0116\nenergy = \"k/2.5 * max(0, d - r)^2.5\"\nconstants = { k = 5e4, d = 0.0116 }",
    ),
    (
        "Hunt and Crossley",
        "between = \"particles\"\nreach = 0.0116\nnormal_force = \"k * overlap^1.5 * (1 - d*vn)\"\nconstants = { k = 5e4, d = 0.5 }",
    ),
    (
        "friction alone",
        "between = \"particles\"\nreach = 0.016\nnormal_force = \"k*overlap\"\ntangential_force = \"-mu * normal * vt / sqrt(vt^2 + s^2)\"\nconstants = { k = 50.0, mu = 0.4, s = 0.02 }",
    ),
    (
        "a Morse bond",
        "between = \"particles\"\nreach = 0.03\nenergy = \"e * (1 - exp(-a*(r - r0)))^2\"\nconstants = { e = 0.01, a = 200.0, r0 = 0.0105 }",
    ),
    (
        "a FENE bond",
        "between = \"particles\"\nreach = 0.0159\nenergy = \"-k/2 * rm^2 * log(1 - (r/rm)^2)\"\nconstants = { k = 5.0, rm = 0.016 }",
    ),
    (
        "drag that grows with speed",
        "between = \"floor\"\nreach = 0.01\nnormal_force = \"-c * vn * vt\"\ntangential_force = \"-c * overlap * vt^2\"\nconstants = { c = 4.0 }",
    ),
    (
        "a wall",
        "between = \"wall\"\nwall = { normal = [1.0, 0.5, 0.0], offset = -0.02 }\nreach = 0.01\nnormal_force = \"k * overlap * exp(-vn)\"\ntangential_force = \"-normal * tanh(vt/s)\"\nconstants = { k = 50.0, s = 0.05 }",
    ),
    (
        "a soft tool",
        "between = \"tool\"\nreach = \"2*h\"\nnormal_force = \"k * exp(-r/h) * overlap^2 - c*vn\"\ntangential_force = \"-c*vt\"\nconstants = { k = 1e4, h = 0.003, c = 2.0 }",
    ),
];

#[test]
fn gradients_of_every_kind_of_formula_agree_with_central_differences() {
    for (name, text) in KINDS {
        let (law, mut rng) = (formula(text), ChaCha8Rng::seed_from_u64(4));
        let bench = Bench::new(1);
        let at: Vec<DVec3> = (0..75).map(|_| vector(&mut rng)).collect();
        let gradient = bench.gradient(&*law, &at);
        assert!(gradient.iter().all(|g| g.is_finite()), "{name}: at rest too");
        for trial in 0..6 {
            let rows: Vec<DVec3> = gradient.iter().map(|_| vector(&mut rng)).collect();
            // Particles, then the tool, then everything.
            let scale = |n: usize| f64::from(u8::from([n < 150, n >= 150, true][trial % 3]));
            let rows: Vec<DVec3> = rows.iter().enumerate().map(|(n, row)| scale(n) * *row).collect();
            let moved = |h: f64| {
                let mut moved = Bench::new(1);
                for i in 0..75 {
                    moved.particles.positions[i] += h * rows[i];
                    // Those at rest stay so: the friction of some has a corner there.
                    let rests = bench.particles.velocities[i] == DVec3::ZERO;
                    moved.particles.velocities[i] += if rests { 0.0 } else { h } * rows[75 + i];
                }
                for k in 0..2 {
                    let Pose { translation, rotation } = &mut moved.poses[k];
                    *translation += h * rows[150 + 2 * k];
                    *rotation = DQuat::from_scaled_axis(h * rows[151 + 2 * k]) * *rotation;
                    moved.twists[k].linear += h * rows[154 + 2 * k];
                    moved.twists[k].angular += h * rows[155 + 2 * k];
                }
                moved.accelerations(&*law).iter().zip(&at).map(|(a, g)| a.dot(*g)).sum::<f64>()
            };
            let rests = |n: &usize| (75..150).contains(n) && bench.particles.velocities[n - 75] == DVec3::ZERO;
            let along = |n: usize| if rests(&n) { 0.0 } else { gradient[n].dot(rows[n]) };
            let exact: f64 = (0..gradient.len()).map(along).sum();
            let differences = [1e-7, 2e-8, 5e-9].map(|h| (moved(h) - moved(-h)) / (2.0 * h));
            let size: f64 = (0..gradient.len()).map(|n| along(n).powi(2)).sum::<f64>().sqrt();
            let least = differences.iter().map(|d| (d - exact).abs()).fold(f64::INFINITY, f64::min);
            assert!(least <= 2e-6 * size.max(exact.abs()), "{name}: {exact} against {differences:?}");
        }
        assert!(gradient.iter().any(|g| *g != DVec3::ZERO), "{name} does nothing here");
    }
}

#[test]
fn an_energy_pushes_down_its_slope_and_keeps_momentum() {
    let by_energy = formula(KINDS[1].1);
    let by_force =
        formula("between = \"particles\"\nreach = 0.0116\nnormal_force = \"k * overlap^1.5\"\nconstants = { k = 5e4 }");
    let bench = Bench::new(3);
    let a = bench.accelerations(&*by_energy);
    close(&bench.accelerations(&*by_force), &a, 1e-13, "k (d − r)^1.5 is the slope of k/2.5 (d − r)^2.5");
    let sum: DVec3 = a.iter().sum();
    let size: f64 = a.iter().map(|v| v.length()).sum();
    assert!(sum.length() <= 1e-14 * size && size > 0.0, "{sum} of {size}");
}

#[test]
fn nothing_acts_at_and_beyond_reach_nor_between_particles_in_one_place() {
    let law = formula("between = \"particles\"\nreach = 0.01\nnormal_force = \"1 + 0*vn\"");
    let at = |distance: f64| {
        let mut bench = Bench::new(0);
        bench.particles = Particles::at_rest(vec![DVec3::ZERO, DVec3::X * distance]);
        bench.graph.edges[0] = EdgeSet { offsets: vec![0, 1, 1], senders: vec![1] };
        (bench.accelerations(&*law)[1], bench.gradient(&*law, &[DVec3::Y, DVec3::X])[1])
    };
    assert_eq!(at(0.00999).0, DVec3::X);
    for distance in [0.01, 0.0100001, 0.02, 0.0] {
        assert_eq!(at(distance), (DVec3::ZERO, DVec3::ZERO), "{distance}");
    }
    let floor = formula("between = \"floor\"\nreach = 0.01\nnormal_force = \"1 + r\"");
    let mut bench = Bench::new(0);
    bench.particles = Particles::at_rest(vec![DVec3::Z * -0.5, DVec3::Z * 0.0099, DVec3::Z * 0.01]);
    assert_eq!(bench.accelerations(&*floor), [DVec3::Z * 0.5, DVec3::Z * 1.0099, DVec3::ZERO]);
}

#[test]
fn more_pairs_than_a_block_and_none_at_all_are_handled() {
    let law = formula(KINDS[0].1);
    let mut bench = Bench::new(0);
    let many = bench.accelerations(&*law);
    // The naive sum, pair by pair, each in a scene of its own.
    let mut naive = vec![DVec3::ZERO; 75];
    let whole = bench.particles.clone();
    bench.graph.edges[0] = EdgeSet { offsets: vec![0, 1, 1], senders: vec![1] };
    for i in 0..75 {
        for j in i + 1..75 {
            let pick = |rows: &[DVec3]| vec![rows[i], rows[j]];
            bench.particles = Particles { positions: pick(&whole.positions), velocities: pick(&whole.velocities) };
            let pair = bench.accelerations(&*law);
            naive[i] += pair[0];
            naive[j] += pair[1];
        }
    }
    assert_eq!(many, naive);
    bench.graph.edges[0] = EdgeSet { offsets: vec![0, 0, 0], senders: Vec::new() };
    assert_eq!(bench.accelerations(&*law), [DVec3::ZERO; 2]);
}
