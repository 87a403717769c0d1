//! Evaluation measures the distance to the truth: nothing for the truth itself, all of it for a model that stands still.
mod toy;
use pliant::data::Episode;
use pliant::model::Dynamics;
use pliant::state::{Control, Particles, Scene};
use pliant::train::{Evaluation, evaluate};
use toy::Toy;

const TRUTH: [f32; 3] = [0.5, 0.8, 0.3];

/// Looks the scene up in the data and returns what followed.
struct Cheat {
    episodes: Vec<Episode>,
}

impl Dynamics for Cheat {
    type State = (usize, usize);

    fn encode(&self, scene: &Scene) -> (usize, usize) {
        let all = self.episodes.iter().enumerate().flat_map(|(e, x)| (0..x.states.len()).map(move |t| (e, t)));
        all.into_iter().find(|(e, t)| self.episodes[*e].states[*t] == scene.particles).expect("a scene of the data")
    }

    fn step(&self, (episode, t): &(usize, usize), control: &Control) -> (usize, usize) {
        assert_eq!(&self.episodes[*episode].controls[*t], control, "the control of that step");
        (*episode, t + 1)
    }

    fn decode(&self, (episode, t): &(usize, usize)) -> Particles {
        self.episodes[*episode].states[*t].clone()
    }
}

/// Adds the same displacement in every step, or breaks down.
struct Drift(f64);

impl Dynamics for Drift {
    type State = Particles;

    fn encode(&self, scene: &Scene) -> Particles {
        scene.particles.clone()
    }

    fn step(&self, state: &Particles, _: &Control) -> Particles {
        Particles::at_rest(state.positions.iter().map(|x| *x + glam::DVec3::X * self.0).collect())
    }

    fn decode(&self, state: &Particles) -> Particles {
        state.clone()
    }
}

fn world() -> Vec<Episode> {
    toy::episodes(&Toy::new(TRUTH), 4, 7, 5)
}

#[test]
fn a_model_that_returns_the_truth_scores_exactly_zero() {
    let score = evaluate(&Cheat { episodes: world() }, &world(), &toy::tools()).unwrap();
    assert_eq!((score.one_step, score.rollout, score.not_finite, score.episodes), (0.0, 0.0, 0, 4));
    assert_eq!(score.curve, vec![0.0; 7]);
    assert!(score.still_one_step > 0.0 && score.still_rollout > score.still_one_step);
}

#[test]
fn a_model_that_stands_still_scores_what_stands_beside_every_other() {
    let score = evaluate(&Drift(0.0), &world(), &toy::tools()).unwrap();
    assert_eq!(score.one_step, score.still_one_step);
    assert_eq!(score.curve, score.still_curve);
    assert_eq!(Some(&score.rollout), score.curve.last());
}

#[test]
fn an_error_that_is_known_is_measured() {
    // In a world where nothing moves, drifting 3 mm a step is 3 mm wrong after one and 21 mm after seven.
    let frozen = toy::episodes(&Toy::new([0.0; 3]), 2, 7, 5);
    let score = evaluate(&Drift(0.003), &frozen, &toy::tools()).unwrap();
    assert!((score.one_step - 0.003).abs() < 1e-12 && (score.rollout - 0.021).abs() < 1e-12);
    assert_eq!(score.still_rollout, 0.0);
}

#[test]
fn a_rollout_that_is_not_finite_is_infinitely_wrong_and_counted() {
    let score = evaluate(&Drift(f64::NAN), &world(), &toy::tools()).unwrap();
    assert_eq!((score.one_step, score.rollout, score.not_finite), (f64::INFINITY, f64::INFINITY, 4 * 7 + 4));
    let text = serde_json::to_string(&score).unwrap();
    assert_eq!(serde_json::from_str::<Evaluation>(&text).unwrap(), score);
}
