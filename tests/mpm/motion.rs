//! What moving points must keep.
use super::*;

#[test]
fn free_fall_is_exact() {
    let spec = MpmSpec { gravity: 9.81, ..elastic() };
    let model = model(spec);
    let throw = DVec3::new(0.3, -0.2, 0.5);
    let positions = block(3.0);
    let velocities = vec![throw; positions.len()];
    let (scene, controls) = alone(Particles { positions, velocities }, 4);
    let rollout = model.rollout(&scene, &controls);
    let h = 0.1 / model.substeps(0.1) as f64;
    for (t, state) in rollout.iter().enumerate() {
        // Symplectic Euler falls g t (t + h)/2.
        let time = 0.1 * t as f64;
        let fall = -9.81 * DVec3::Z;
        for i in 0..state.len() {
            let place = scene.particles.positions[i] + time * throw + 0.5 * time * (time + h) * fall;
            assert!(state.positions[i].distance(place) < 1e-12, "step {t}");
            assert!(state.velocities[i].distance(throw + time * fall) < 1e-12, "step {t}");
        }
    }
}

#[test]
fn momentum_and_spin_are_kept_without_outside_forces() {
    for spec in [elastic(), MpmSpec { yield_stress: 50.0, viscosity: 2.0, ..elastic() }] {
        let cell = spec.cell;
        // Single precision rounds velocities of 0.1 m/s by 6e-9 in each of some fifty substeps a step, here and there.
        for (precision, rounding) in [(Precision::Double, 1e-10), (Precision::Single, 1e-5)] {
            let model = model(MpmSpec { precision, ..spec.clone() });
            let (scene, controls) = alone(stirred(), 5);
            let mut state = model.encode(&scene);
            let (p, l) = state.momentum(cell);
            let before = model.decode(&state);
            for control in &controls {
                state = model.step(&state, control);
            }
            let (p_after, l_after) = state.momentum(cell);
            assert!(p.distance(p_after) < rounding * p.length(), "{precision:?}: {p} became {p_after}");
            assert!(l.distance(l_after) < rounding * l.length(), "{precision:?}: {l} became {l_after}");
            let after = model.decode(&state);
            let pairs = before.velocities.iter().zip(&after.velocities);
            let changed = pairs.map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
            assert!(changed > 0.05, "nothing happened");
        }
    }
}

#[test]
fn relabelled_particles_have_relabelled_futures_bit_for_bit() {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let positions: Vec<DVec3> = block(0.002).into_iter().map(|x| x + 0.001 * problem::vector(&mut rng).abs()).collect();
    let scene = under(Particles::at_rest(positions), 0.045);
    let controls: Vec<Control> = (1..=4).map(|t| Control { poses: vec![at(0.045 - 0.004 * f64::from(t))] }).collect();
    let count = scene.particles.len();
    let order: Vec<usize> = (0..count).map(|i| (i * 151 + 7) % count).collect();
    let shuffle = |rows: &[DVec3]| order.iter().map(|&i| rows[i]).collect::<Vec<_>>();
    let mut relabelled = scene.clone();
    relabelled.particles.positions = shuffle(&scene.particles.positions);
    relabelled.particles.velocities = shuffle(&scene.particles.velocities);
    for precision in [Precision::Double, Precision::Single] {
        let model = model(MpmSpec { gravity: 1.0, precision, ..shipped() });
        let [straight, shuffled] = [&scene, &relabelled].map(|scene| model.rollout(scene, &controls));
        for (a, b) in straight.iter().zip(&shuffled) {
            assert_eq!((shuffle(&a.positions), shuffle(&a.velocities)), (b.positions.clone(), b.velocities.clone()));
        }
        assert!(straight[4].positions[0] != straight[0].positions[0], "nothing happened");
    }
}

#[test]
fn what_is_blown_apart_is_no_number_and_no_panic() {
    let model = model(elastic());
    let mut particles = Particles::at_rest(block(1.0));
    particles.positions[3] = DVec3::splat(1e9);
    let (scene, controls) = alone(particles, 2);
    assert!(!model.rollout(&scene, &controls)[2].is_finite());
    let (empty, controls) = alone(Particles::default(), 1);
    assert!(model.rollout(&empty, &controls)[1].is_empty());
}
