//! Derivatives of whole rollouts against central differences.
use super::{COUNT, Mixed, problem, shaken, specs, vector};
use glam::{DQuat, DVec3};
use pliant::model::{Cost, Gradient, WorldModel};
use pliant::state::{Control, Pose, PoseGrad, Scene};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A direction in all that a rollout depends on but weights.
#[derive(Clone, Default)]
struct Direction {
    positions: Vec<DVec3>,
    start: Vec<[DVec3; 2]>,
    controls: Vec<Vec<[DVec3; 2]>>,
}

fn turned(pose: &Pose, [shift, turn]: &[DVec3; 2], h: f64) -> Pose {
    Pose { translation: pose.translation + h * *shift, rotation: DQuat::from_scaled_axis(h * *turn) * pose.rotation }
}

impl Direction {
    fn cost(&self, model: &dyn WorldModel, (scene, controls): &(Scene, Vec<Control>), cost: &Mixed, h: f64) -> f64 {
        let nudge = |poses: &[Pose], by: &[[DVec3; 2]]| poses.iter().zip(by).map(|(p, d)| turned(p, d, h)).collect();
        let mut scene = scene.clone();
        scene.particles.positions.iter_mut().zip(&self.positions).for_each(|(x, d)| *x += h * *d);
        scene.poses = nudge(&scene.poses, &self.start);
        let controls: Vec<Control> =
            controls.iter().zip(&self.controls).map(|(c, by)| Control { poses: nudge(&c.poses, by) }).collect();
        cost.total(&model.rollout(&scene, &controls))
    }

    fn along(&self, gradient: &Gradient) -> f64 {
        let pose = |g: &PoseGrad, [shift, turn]: &[DVec3; 2]| g.translation.dot(*shift) + g.rotation.dot(*turn);
        let poses = |g: &[PoseGrad], d: &[[DVec3; 2]]| g.iter().zip(d).map(|(g, d)| pose(g, d)).sum::<f64>();
        let positions = gradient.scene.particles.positions.iter().zip(&self.positions);
        positions.map(|(g, d)| g.dot(*d)).sum::<f64>()
            + poses(&gradient.scene.poses, &self.start)
            + gradient.controls.iter().zip(&self.controls).map(|(g, d)| poses(&g.poses, d)).sum::<f64>()
    }
}

/// Every kind of direction; a turn moves a part's surface about as far as a shift does.
fn directions(rng: &mut ChaCha8Rng, steps: usize) -> Vec<(&'static str, Direction)> {
    let mut all = Vec::new();
    for trial in 0..12 {
        let [particles, start, shift, turn] = [trial % 4 == 0, trial % 4 == 1, trial % 4 == 2, trial % 4 == 3];
        let share = |wanted: bool| if wanted { 1.0 } else { 0.0 };
        let mut pose = |wanted: [f64; 2]| [wanted[0] * vector(rng), 60.0 * wanted[1] * vector(rng)];
        let name = if particles {
            "particles"
        } else if start {
            "start"
        } else if shift {
            "shifts"
        } else {
            "turns"
        };
        let direction = Direction {
            start: (0..2).map(|_| pose([share(start); 2])).collect(),
            controls: (0..steps).map(|_| (0..2).map(|_| pose([share(shift), share(turn)])).collect()).collect(),
            positions: (0..COUNT).map(|_| share(particles) * vector(rng)).collect(),
        };
        all.push((name, direction));
    }
    all
}

/// The differences of several steps: kinks of the picture spoil large ones, rounding of the network in single precision small ones.
fn differences(scale: f64, cost: impl Fn(f64) -> f64) -> [f64; 5] {
    [1e-1, 3e-2, 1e-2, 3e-3, 1e-3].map(|h| {
        let h = scale * h;
        (8.0 * (cost(h) - cost(-h)) - (cost(2.0 * h) - cost(-2.0 * h))) / (12.0 * h)
    })
}

#[test]
fn derivatives_of_rollouts_agree_with_central_differences() {
    let (problem, cost) = (problem(), Mixed::random());
    for (name, spec) in specs() {
        let mut model = shaken(&spec);
        let gradient = model.weight_gradient(&problem.0, &problem.1, &cost).unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(21);
        let trials: Vec<(&str, f64, [f64; 5])> = directions(&mut rng, problem.1.len())
            .into_iter()
            .map(|(what, direction)| {
                let found = differences(1e-3, |h| direction.cost(&*model, &problem, &cost, h));
                (what, direction.along(&gradient), found)
            })
            .collect();
        for what in ["particles", "start", "shifts", "turns"] {
            let own: Vec<_> = trials.iter().filter(|(kind, ..)| *kind == what).collect();
            let typical = (own.iter().map(|(_, d, _)| d * d).sum::<f64>() / own.len() as f64).sqrt();
            assert!(typical > 1e-3, "{name}, {what}: derivatives of about {typical} show nothing");
            for (_, exact, found) in own {
                let best = found.map(|d| (d - exact).abs()).into_iter().fold(f64::INFINITY, f64::min);
                assert!(best < 2e-3 * typical, "{name}, {what}: {exact} against {found:?}");
            }
        }
        let before = model.weights();
        let trials: Vec<(f64, [f64; 4])> = (0..6)
            .map(|_| {
                let direction: Vec<f32> = before.iter().map(|_| rng.random_range(-1.0..1.0)).collect();
                let mut at = |h: f32| {
                    model.set_weights(&before.iter().zip(&direction).map(|(w, d)| w + h * d).collect::<Vec<_>>());
                    cost.total(&model.rollout(&problem.0, &problem.1))
                };
                let exact = gradient.weights.iter().zip(&direction).map(|(g, d)| f64::from(g * d)).sum();
                (exact, [1e-2, 3e-3, 1e-3, 3e-4].map(|h: f32| (at(h) - at(-h)) / (2.0 * f64::from(h))))
            })
            .collect();
        let typical = (trials.iter().map(|(d, _)| d * d).sum::<f64>() / trials.len() as f64).sqrt();
        assert!(typical > 1e-4, "{name}: derivatives by weights of about {typical} show nothing");
        for (exact, found) in trials {
            let best = found.map(|d| (d - exact).abs()).into_iter().fold(f64::INFINITY, f64::min);
            assert!(best < 5e-3 * typical, "{name}, weights: {exact} against {found:?}");
        }
        model.set_weights(&before);
    }
}
