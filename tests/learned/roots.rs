//! The learned law under roots.
use crate::derivatives_agree_with_central_differences;
use crate::moment::*;
use glam::DVec3;
use pliant::model::law::LearnedSpec;

#[test]
fn derivatives_through_roots_agree_with_central_differences() {
    for counts in [&[6][..], &[9, 3]] {
        let law = shake(LearnedSpec { edges: kinds(6), rounds: 3, ..spec(16) });
        derivatives_agree_with_central_differences(&law, &Moment::random(40).rooted(counts));
    }
}

#[test]
fn through_roots_news_crosses_a_body_in_one_step_however_long_it_is() {
    // A root knows the mean of its particles from the start: across to the other end's root and down, two rounds.
    for length in [40, 400] {
        let bar = |push: f64| {
            let mut m = Moment::random(length);
            m.tool.parts.clear();
            m.particles.positions = (0..length).map(|i| DVec3::new(0.01 * i as f64, 0.0, 1.0)).collect();
            m.particles.velocities = vec![DVec3::ZERO; length];
            m.particles.velocities[0] = push * DVec3::X;
            m
        };
        let moved = |rounds: usize, edges: usize, counts: &[usize]| {
            let law = shake(LearnedSpec { edges: kinds(edges), rounds, ..spec(16) });
            let at = |push: f64| bar(push).rooted(counts).acceleration(&law)[length - 1];
            at(0.0).distance(at(0.02))
        };
        assert!(moved(2, 6, &[8]) > 0.0, "{length} particles: the other end hears of the push");
        assert_eq!(moved(3, 3, &[]), 0.0, "without roots it is farther than three radii");
        assert_eq!(moved(1, 6, &[8]), 0.0, "one round is too few");
    }
}
