//! Gradients of rollouts whose prediction is corrected at the end of every control step.
use super::problem::Mixed;
use super::*;
use pliant::model::correction::{Correction, Feature, OutputResidual};
use pliant::model::law::{Rate, View, ViewGrad};

/// A stand-in for a network that is exact in f64: neighbours, tool, and velocities of the past.
struct Exact(Drift, Memory);

impl Exact {
    fn boxed(drift: [f32; 3], memory: &[f64]) -> Box<dyn Law> {
        Box::new(Self(Drift { weights: drift.to_vec() }, Memory(memory.to_vec())))
    }
}

impl Law for Exact {
    fn rate(&self) -> Rate {
        Rate::Step
    }
    fn memory(&self) -> usize {
        self.1.memory()
    }
    fn accelerate(&self, view: &View<'_>, out: &mut [DVec3]) {
        self.0.accelerate(view, out);
        self.1.accelerate(view, out);
    }
    fn accelerate_vjp(&self, view: &View<'_>, out: &[DVec3], grad: &mut ViewGrad<'_>) {
        self.0.accelerate_vjp(view, out, grad);
        self.1.accelerate_vjp(view, out, grad);
    }
    fn weights(&self) -> Vec<f32> {
        self.0.weights()
    }
    fn set_weights(&mut self, weights: &[f32]) {
        self.0.set_weights(weights);
    }
}

pub(crate) fn corrected(corrections: Vec<Box<dyn Correction>>) -> ParticleModel {
    let graph: GraphSpec =
        toml_edit::de::from_str("kind = \"radius\"\nradius = 0.02\nedges = [\"particle\", \"tool\"]").unwrap();
    let model = ParticleModel::new(40, 0.01, Some(graph.build().unwrap()), analytic_laws()).unwrap();
    model.corrected(corrections).unwrap()
}

fn output_residual() -> Box<dyn Correction> {
    Box::new(OutputResidual::of(Exact::boxed([2.0, 0.125, 0.75], &[0.5, -0.3, 0.4])))
}

/// About the motion that the laws predict, which an acceleration of 10/s times the mean velocity is.
fn feature() -> Box<dyn Correction> {
    Box::new(Feature::of(Exact::boxed([2.0, 0.125, 0.75], &[9.0, 0.7, -0.5])))
}

#[test]
fn the_gradient_through_a_corrected_prediction_agrees_with_central_differences() {
    check(&corrected(vec![output_residual()]), "output residual", |_| ());
    check(&corrected(vec![feature()]), "feature", |_| ());
    check(&corrected(vec![feature(), output_residual()]), "both", |_| ());
}

#[test]
fn the_gradient_by_a_corrections_weights_agrees_with_central_differences() {
    let problem = problem(&mut ChaCha8Rng::seed_from_u64(11));
    for corrections in [vec![output_residual()], vec![feature()], vec![feature(), output_residual()]] {
        weights_agree(&mut corrected(corrections), &problem);
    }
}

/// Checks `∂J/∂weights` of a model that is exact in f64.
fn weights_agree(model: &mut ParticleModel, problem: &(Scene, Vec<Control>, Mixed)) {
    let gradient = model.weight_gradient(&problem.0, &problem.1, &problem.2).unwrap();
    let weights = WorldModel::weights(model);
    assert_eq!(gradient.weights.len(), weights.len());
    for i in 0..weights.len() {
        let h = weights[i].abs() / 1048576.0;
        let mut nudged = |h: f32| {
            let mut weights = weights.clone();
            weights[i] += h;
            WorldModel::set_weights(model, &weights);
            problem.2.total(&model.rollout(&problem.0, &problem.1))
        };
        let difference = (nudged(h) - nudged(-h)) / (2.0 * f64::from(h));
        let exact = f64::from(gradient.weights[i]);
        assert!(difference.abs() > 1e-9, "weight {i} does nothing");
        assert!((exact - difference).abs() <= 1e-4 * difference.abs(), "weight {i}: {exact} against {difference}");
    }
}
