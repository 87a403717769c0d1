//! The other kinds of learned model: their gradients are what central differences of their rollouts are, by weights too.
use super::direction::Direction;
use super::problem::{STEPS, problem, vector};
use glam::DVec3;
use pliant::model::Cost;
use pliant::state::{Particles, ParticlesGrad, Twist};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use specs::{shaken, specs};

#[path = "../kinds/specs.rs"]
mod specs;

/// The least error of differences of several steps: kinks of a picture spoil large ones, a network's single precision small ones.
fn error<const N: usize>(exact: f64, steps: [f64; N], mut cost: impl FnMut(f64) -> f64) -> f64 {
    let errors = steps.map(|h| {
        let difference = (8.0 * (cost(h) - cost(-h)) - (cost(2.0 * h) - cost(-2.0 * h))) / (12.0 * h);
        (difference - exact).abs()
    });
    errors.into_iter().fold(f64::INFINITY, f64::min)
}

/// All particles move as one, and nothing else does.
fn together(along: DVec3) -> Direction {
    let start = vec![Twist::default(); 2];
    let (positions, velocities) = (vec![along; 48], vec![DVec3::ZERO; 48]);
    Direction { positions, velocities, controls: vec![start.clone(); STEPS], start }
}

fn typical(values: &[(f64, f64)]) -> f64 {
    (values.iter().map(|(exact, _)| exact * exact).sum::<f64>() / values.len() as f64).sqrt()
}

#[test]
fn pictures_and_codes_have_the_gradients_of_their_rollouts() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let problem = problem(&mut rng);
    for (name, spec) in specs() {
        let mut model = shaken(&spec);
        let gradient = model.weight_gradient(&problem.0, &problem.1, &problem.2).unwrap();
        for (what, [particles, start, controls]) in
            [("particles", [1.0, 0.0, 0.0]), ("start", [0.0, 1.0, 0.0]), ("controls", [0.0, 0.0, 1.0])]
        {
            let mut directions: Vec<Direction> =
                (0..6).map(|_| Direction::random(&mut rng, particles, start, controls)).collect();
            if what == "particles" {
                directions.extend(DVec3::AXES.map(together));
            }
            let trials: Vec<(f64, f64)> = directions
                .iter()
                .map(|direction| {
                    let (exact, steps) = (direction.along(&gradient), [3e-4, 1e-4, 3e-5, 1e-5, 3e-6, 1e-6]);
                    (exact, error(exact, steps, |h| direction.cost(&*model, &problem, h)))
                })
                .collect();
            let size = typical(&trials);
            assert!(size > 1e-2, "{name}, {what}: derivatives of about {size} show nothing");
            for (exact, error) in trials {
                assert!(error < 2e-3 * size, "{name}, {what}: {exact} is off by {error}");
            }
        }
        let before = model.weights();
        let trials: Vec<(f64, f64)> = (0..6)
            .map(|_| {
                let direction: Vec<f32> = before.iter().map(|_| rng.random_range(-1.0..1.0)).collect();
                let exact = gradient.weights.iter().zip(&direction).map(|(g, d)| f64::from(g * d)).sum();
                let error = error(exact, [1e-2, 3e-3, 1e-3, 3e-4], |h| {
                    model
                        .set_weights(&before.iter().zip(&direction).map(|(w, d)| w + h as f32 * d).collect::<Vec<_>>());
                    problem.2.total(&model.rollout(&problem.0, &problem.1))
                });
                (exact, error)
            })
            .collect();
        let size = typical(&trials);
        assert!(size > 1e-4, "{name}: derivatives by weights of about {size} show nothing");
        for (exact, error) in trials {
            assert!(error < 5e-3 * size, "{name}, weights: {exact} is off by {error}");
        }
    }
}

/// `J = Σ aᵢ·x_H` over the two lower layers of the lump.
struct Below(Vec<DVec3>);

impl Cost for Below {
    fn at(&self, t: usize, horizon: usize, x: &Particles) -> f64 {
        if t < horizon { 0.0 } else { self.0.iter().zip(&x.positions).map(|(a, x)| a.dot(*x)).sum() }
    }
    fn gradient(&self, t: usize, horizon: usize, x: &Particles) -> ParticlesGrad {
        let mut grad = ParticlesGrad::zero(x.len());
        if t == horizon {
            grad.positions[..self.0.len()].copy_from_slice(&self.0);
        }
        grad
    }
}

/// Where a particle lies is seen from above or told to the code, and moves others by that alone.
#[test]
fn what_moves_others_through_the_picture_or_the_code_has_its_gradient() {
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let (scene, controls, _) = problem(&mut rng);
    let cost = Below((0..32).map(|_| 1e3 * vector(&mut rng)).collect());
    for (name, spec) in specs() {
        let model = shaken(&spec);
        let gradient = model.gradient(&scene, &controls, &cost).unwrap().scene.particles.positions;
        let trials: Vec<(f64, f64)> = (0..6)
            .map(|_| {
                let along: Vec<DVec3> = (32..48).map(|_| vector(&mut rng)).collect();
                let exact = gradient[32..].iter().zip(&along).map(|(g, d)| g.dot(*d)).sum();
                let error = error(exact, [1e-4, 3e-5, 1e-5, 3e-6, 1e-6], |h| {
                    let mut moved = scene.clone();
                    moved.particles.positions[32..].iter_mut().zip(&along).for_each(|(x, d)| *x += h * *d);
                    cost.total(&model.rollout(&moved, &controls))
                });
                (exact, error)
            })
            .collect();
        let size = typical(&trials);
        assert!(size > 1e-2, "{name}: derivatives of about {size} show nothing");
        for (exact, error) in trials {
            assert!(error < 2e-2 * size, "{name}: {exact} is off by {error}");
        }
    }
}
