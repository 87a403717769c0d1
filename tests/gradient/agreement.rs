//! Whether a model's gradient is what central differences of its rollouts are.
use super::direction::Direction;
use super::problem::problem;
use pliant::model::WorldModel;
use pliant::state::Scene;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// What the scene is besides one body on an open table.
pub(crate) type Change = fn(&mut Scene);

/// Steps small against the lengths over which a contact's second derivative changes, large against rounding; of several, because a
/// contact that just closes within one of them bends the cost there.
pub(crate) fn check(model: &dyn WorldModel, name: &str, change: Change) {
    check_at(model, name, change, [1e-8, 2e-9, 5e-10], 1e-6);
}

/// The same with other steps, whose best error in every direction is at most `tolerance`.
pub(crate) fn check_at(model: &dyn WorldModel, name: &str, change: Change, steps: [f64; 3], tolerance: f64) {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let mut problem = problem(&mut rng);
    change(&mut problem.0);
    let gradient = model.gradient(&problem.0, &problem.1, &problem.2).expect("a particle model has an adjoint");
    let apart = Direction::random(&mut rng, 0.0, 0.0, 0.0).cost(model, &problem, 0.0);
    assert!((gradient.cost - apart).abs() <= 1e-12 * apart.abs(), "the sweep's cost is the rollout's");
    let kinds =
        [("particles", [1.0, 0.0, 0.0]), ("start", [0.0, 1.0, 0.0]), ("controls", [0.0, 0.0, 1.0]), ("all", [1.0; 3])];
    for (what, [particles, start, controls]) in kinds {
        let trials: Vec<(f64, [f64; 3])> = (0..8)
            .map(|_| {
                let direction = Direction::random(&mut rng, particles, start, controls);
                let cost = |h: f64| direction.cost(model, &problem, h);
                (direction.along(&gradient), steps.map(|h| (cost(h) - cost(-h)) / (2.0 * h)))
            })
            .collect();
        let typical = (trials.iter().map(|(_, d)| d[1] * d[1]).sum::<f64>() / trials.len() as f64).sqrt();
        assert!(typical > 0.1, "{name}, {what}: derivatives of about {typical} show nothing");
        for (exact, differences) in trials {
            let errors = differences.map(|d| (exact - d).abs() / d.abs().max(typical));
            assert!(errors.iter().all(|e| *e <= 1e-4), "{name}, {what}: {exact} against {differences:?}");
            assert!(errors.iter().any(|e| *e <= tolerance), "{name}, {what}: {exact} against {differences:?}");
        }
    }
}
