//! How far a learned law hears: as many radii as there are rounds of messages, and not a step farther.
use crate::moment::*;
use glam::DVec3;
use pliant::model::law::LearnedSpec;

/// Distance between neighbours of a line: ten of them are the longest leap of these tests, just inside the radius.
const SPACING: f64 = 0.098 * RADIUS;

/// By how much the first particle of a line is accelerated otherwise when another, at a `distance` from it, is fast.
fn felt(rounds: usize, distance: f64) -> f64 {
    let law = shake(LearnedSpec { rounds, ..spec(16) });
    let between = (1..).map(|k| SPACING * f64::from(k)).take_while(|x| *x < 0.999 * distance);
    // Above the reach of table and tool.
    let line: Vec<DVec3> =
        [0.0].into_iter().chain(between).chain([distance]).map(|x| DVec3::new(x, 0.0, 1.0)).collect();
    let mut here = Moment::random(line.len());
    here.tool.parts.clear();
    here.particles.positions = line;
    let mut with = |speed: f64| {
        here.particles.velocities.fill(DVec3::ZERO);
        *here.particles.velocities.last_mut().unwrap() = speed * DVec3::Y;
        here.acceleration(&law)[0]
    };
    // So fast that it shows in single precision through windows that are almost shut, one after the other.
    with(0.0).distance(with(1e9 * SCALE / INTERVAL))
}

#[test]
fn every_round_reaches_one_radius_farther_and_nothing_beyond_changes_a_bit() {
    for rounds in 1..=3 {
        let reach = rounds as f64 * RADIUS;
        let (inside, outside) = (0.98 * reach, (1.0 + 1e-9) * reach);
        assert!(felt(rounds, inside) > 0.0, "{rounds} rounds carry what is just inside their reach");
        assert_eq!(felt(rounds, outside), 0.0, "{rounds} rounds carry nothing from just outside their reach");
        assert!(felt(rounds + 1, outside) > 0.0, "the line would carry it on in another round");
        if rounds > 1 {
            assert_eq!(felt(rounds - 1, inside), 0.0, "{rounds} rounds are needed");
        }
    }
}
