//! Bonds: springs that yield as one-dimensional plasticity says, break at their strain, and keep momentum.
use super::integrator::relabelled;
use super::*;
use proptest::prelude::*;

const STIFFNESS: f64 = 900.0;
const LENGTH: f64 = 0.01;

fn bonds(more: &str) -> Box<dyn Law> {
    law(&format!("kind = \"bonds\"\nreach = 0.013\nstiffness = {STIFFNESS}\n{more}"))
}

/// A pair along x, at this distance, of which the second moves away at this speed.
fn pair(distance: f64, speed: f64) -> Particles {
    Particles { positions: vec![DVec3::ZERO, DVec3::X * distance], velocities: vec![DVec3::ZERO, DVec3::X * speed] }
}

/// The bond's history and the pull on its second end towards the first, after its length went through `path`.
fn through(law: &dyn Law, path: &[f64]) -> (History, Vec<f64>) {
    let memory = law.remembers().expect("bonds remember");
    let mut history = memory.begin(&pair(LENGTH, 0.0), &[0, 0]);
    let pull = |r: &f64| {
        let particles = pair(*r, 0.0);
        history = seen(&particles, &history, |view| memory.advance(view, 1e-3));
        let mut out = vec![DVec3::ZERO; 2];
        seen(&particles, &history, |view| law.accelerate(view, &mut out));
        assert_eq!(out[0], -out[1]);
        out[0].x
    };
    let pulls = path.iter().map(pull).collect();
    (history, pulls)
}

#[test]
fn a_bond_yields_as_the_return_mapping_says_and_keeps_its_set() {
    let yields = 0.05;
    let law = bonds(&format!("damping = 0.0\nyield_strain = {yields}"));
    let (top, low) = (1.2 * LENGTH, 0.8 * LENGTH);
    // Pulled beyond its yield strain, let go to where it no longer pulls, pushed together, and back.
    let set = top / (1.0 + yields);
    let (history, pulls) = through(&*law, &[1.04 * LENGTH, top, set, low, low / (1.0 - yields)]);
    let flowed = STIFFNESS * yields;
    let expected = [STIFFNESS * 0.04 * LENGTH, flowed * set, 0.0, -flowed * low / (1.0 - yields), 0.0];
    for (pull, expected) in pulls.iter().zip(expected) {
        assert!((pull - expected).abs() < 1e-13, "{pulls:?}, {expected}");
    }
    assert!((history.values()[0] - low / (1.0 - yields)).abs() < 1e-15);
    assert_eq!(history.values()[1], LENGTH);
    // Flow knows no rate: a hundred small pulls end where a single one does.
    let gently: Vec<f64> = (1..=100).map(|n| LENGTH + (top - LENGTH) * f64::from(n) / 100.0).collect();
    let (slow, _) = through(&*law, &gently);
    assert!((slow.values()[0] - set).abs() < 1e-15);
    // Work over a closed cycle is what flow took: pull times flow on both ways.
    let steps = 4000;
    let cycle: Vec<f64> = (0..=steps)
        .map(|n| LENGTH * (1.0 + 0.2 * (std::f64::consts::TAU * f64::from(n) / f64::from(steps)).sin()))
        .collect();
    let (_, pulls) = through(&*law, &cycle);
    let work: f64 = cycle.windows(2).zip(pulls.windows(2)).map(|(r, f)| 0.5 * (f[0] + f[1]) * (r[1] - r[0])).sum();
    assert!(work > 2.0 * flowed * LENGTH * 0.2 * LENGTH, "{work}: flow takes energy");
    let (_, pulls) = through(&*bonds("damping = 0.0"), &cycle);
    let work: f64 = cycle.windows(2).zip(pulls.windows(2)).map(|(r, f)| 0.5 * (f[0] + f[1]) * (r[1] - r[0])).sum();
    assert!(work.abs() < 1e-12, "{work}: without flow nothing is lost");
}

#[test]
fn a_bonded_pair_swings_at_its_frequency() {
    // Half a period of ω = √(2k) turns a stretch into a squeeze; the pair starts bonded at rest and moves apart.
    let (speed, omega) = (0.01, (2.0 * STIFFNESS).sqrt());
    let (start, controls) = alone(pair(LENGTH, speed), 1);
    let start = Scene { interval: 1.5 * std::f64::consts::PI / omega, ..start };
    let end = model(20_000, vec![bonds("damping = 0.0")]).rollout(&start, &controls).pop().unwrap();
    let gap = end.positions[0].distance(end.positions[1]);
    assert!((gap - (LENGTH - speed / omega)).abs() < 1e-3 * speed / omega, "{gap}");
}

#[test]
fn a_bond_holds_what_is_too_slow_to_break_it_and_lets_go_for_good_of_what_is_not() {
    let breaks = 0.1;
    let law = || bonds(&format!("damping = 0.0\nbreaking_strain = {breaks}"));
    // All of ½ u² goes into k s² at the breaking stretch s.
    let least = (2.0 * STIFFNESS).sqrt() * breaks * LENGTH;
    let after = |speed: f64| {
        let (start, controls) = alone(pair(LENGTH, speed), 10);
        let rollout = model(4000, vec![law()]).rollout(&start, &controls);
        let end = rollout.last().unwrap();
        (end.positions[0].distance(end.positions[1]), end.velocities[1].x - end.velocities[0].x)
    };
    assert!(after(0.98 * least).0 < (1.0 + breaks) * LENGTH);
    let (gap, speed) = after(1.1 * least);
    let expected = least * (1.1_f64 * 1.1 - 1.0).sqrt();
    assert!((speed / expected - 1.0).abs() < 1e-2, "{speed} against {expected}");
    assert!(gap > 1.5 * LENGTH);
    let (history, pulls) = through(&*law(), &[1.2 * LENGTH, 1.05 * LENGTH, LENGTH]);
    assert_eq!((history.pairs().len(), &pulls[..]), (0, &[0.0; 3][..]), "a broken bond stays broken");
}

#[test]
fn particles_are_bonded_within_reach_and_within_their_body() {
    let far = DVec3::X * 0.03;
    let positions = vec![DVec3::ZERO, DVec3::X * 0.012, DVec3::Y * 0.0131, far, far + DVec3::X * 0.012];
    let law = bonds("damping = 1.0");
    let history = law.remembers().unwrap().begin(&Particles::at_rest(positions), &[0, 0, 0, 1, 2]);
    assert_eq!(history.pairs(), [[0, 1]]);
    assert_eq!(history.row::<2>(0), [0.012; 2]);
}

/// Momentum, angular momentum and how far all moved, of a lump thrown apart under these bonds.
fn thrown(more: &str) -> (f64, f64, Particles) {
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let positions = block();
    let particles = Particles { velocities: positions.iter().map(|_| 0.2 * vector(&mut rng)).collect(), positions };
    let (start, controls) = alone(particles, 3);
    let mut rollout = model(80, vec![bonds(more)]).rollout(&start, &controls);
    let momenta = |x: &Particles| {
        let rows = x.positions.iter().zip(&x.velocities);
        rows.fold((DVec3::ZERO, DVec3::ZERO), |(p, l), (x, v)| (p + *v, l + x.cross(*v)))
    };
    let rows = || rollout[0].positions.iter().zip(&rollout[0].velocities);
    let (speed, turn) = rows().fold((0.0, 0.0), |(a, b), (x, v)| (a + v.length(), b + x.length() * v.length()));
    let [(p0, l0), (p1, l1)] = [momenta(&rollout[0]), momenta(&rollout[3])];
    (p0.distance(p1) / speed, l0.distance(l1) / turn, rollout.pop().unwrap())
}

#[test]
fn momentum_is_kept_through_flow_and_breaking() {
    let kinds = ["", "yield_strain = 0.05", "yield_strain = 0.05\nbreaking_strain = 0.2"];
    let ends = kinds.map(|more| {
        let (linear, angular, end) = thrown(&format!("damping = 3.0\n{more}"));
        assert!(linear < 1e-10 && angular < 1e-10, "{more}: {linear} and {angular}");
        end
    });
    for pair in ends.windows(2) {
        let apart = pair[0].positions.iter().zip(&pair[1].positions).map(|(a, b)| a.distance(*b));
        assert!(apart.fold(0.0, f64::max) > 1e-3, "bonds neither flowed nor broke");
    }
}

#[test]
fn impossible_bonds_are_refused() {
    let refused = |text: &str| {
        let spec: LawSpec = toml_edit::de::from_str(&format!("kind = \"bonds\"\ndamping = 1.0\n{text}")).unwrap();
        spec.build().err().expect("impossible bonds").to_string()
    };
    assert!(refused("reach = 0.0\nstiffness = 1.0").contains("reach"));
    assert!(refused("reach = 0.01\nstiffness = -1.0").contains("stiffness"));
    assert!(refused("reach = 0.01\nstiffness = 1.0\nyield_strain = 1.0").contains("yield_strain"));
    assert!(refused("reach = 0.01\nstiffness = 1.0\nbreaking_strain = 0.0").contains("breaking_strain"));
}

fn bonded() -> Box<dyn WorldModel> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/configs/model/bonds.toml");
    toml_edit::de::from_str::<Contender>(&std::fs::read_to_string(path).unwrap()).unwrap().dynamics.build().unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(8))]
    #[test]
    fn relabelling_bonded_particles_relabels_the_rollout_bit_for_bit(
        order in Just((0..120).collect::<Vec<usize>>()).prop_shuffle(), seed in 0u64..1000,
    ) {
        let model = bonded();
        let [rollout, relabelled] = relabelled(&*model, &order, seed);
        for (x, y) in rollout.iter().zip(&relabelled) {
            prop_assert!(x.is_finite());
            prop_assert_eq!(x, y);
        }
    }
}
