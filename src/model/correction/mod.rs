//! Corrections: what is done, once a control step, to what the laws predict for its end.
//!
//! A law says how particles accelerate; a correction sees where all laws together took them and says where they are instead, one
//! after the other in the order of the config.
use super::law::{Law, View, ViewGrad};
use crate::graph::Graph;
use crate::state::{Particles, ParticlesGrad, Scene};
use std::path::Path;

mod feature;
mod motion;
mod output_residual;
pub mod projection;

pub use feature::{Feature, FeatureSpec};
pub use output_residual::{OutputResidual, OutputResidualSpec};

/// What a correction may look at.
pub struct Outcome<'a> {
    /// The start of the control step, with the tool at its end; no graph.
    pub before: View<'a>,
    /// The particles at the end of the control step, as far as laws and earlier corrections say.
    pub predicted: &'a Particles,
    /// The graph that the model's policy draws over particles and the tool at the end of the step.
    pub connect: &'a dyn Fn(&Particles) -> Graph,
}

/// `∂J/∂outcome`, and `∂J/∂weights` of the correction.
pub struct OutcomeGrad<'a> {
    /// The start's part.
    pub before: ViewGrad<'a>,
    /// The prediction's part.
    pub predicted: ParticlesGrad,
}

/// A change of the prediction of a whole control step.
pub trait Correction: Send + Sync {
    /// The network that it asks, if any, once a control step and of what the laws predict.
    fn network(&self) -> Option<&dyn Law> {
        None
    }
    /// The same, for its weights to be replaced.
    fn network_mut(&mut self) -> Option<&mut dyn Law> {
        None
    }
    /// Whether this correction can be asked about what starts from `scene`; called before any rollout.
    ///
    /// # Errors
    /// A sentence saying what does not suit the correction.
    fn accepts(&self, scene: &Scene) -> anyhow::Result<()> {
        self.network().map_or(Ok(()), |network| network.accepts(scene))
    }
    /// Number of velocities before the start of the control step that it looks at: what a network sees first is the prediction.
    fn memory(&self) -> usize {
        self.network().map_or(0, |network| network.memory().saturating_sub(1))
    }
    /// Whether it asks for a graph.
    fn draws(&self) -> bool {
        self.network().is_some()
    }
    /// The particles at the end of the control step.
    fn correct(&self, outcome: &Outcome<'_>) -> Particles;
    /// Adds `∂J/∂outcome` to `grad`, from `at` = `∂J/∂particles` that [`Correction::correct`] gives.
    fn correct_vjp(&self, outcome: &Outcome<'_>, at: &ParticlesGrad, grad: &mut OutcomeGrad<'_>);
    /// Trainable weights, flat.
    fn weights(&self) -> Vec<f32> {
        self.network().map_or_else(Vec::new, |network| network.weights())
    }
    /// Name of each weight matrix, as the file of weights has it, and how many weights it holds, in the order of
    /// [`Correction::weights`].
    fn matrices(&self) -> Vec<(String, usize)> {
        self.network().map_or_else(Vec::new, |network| network.matrices())
    }
    /// Replaces the weights.
    fn set_weights(&mut self, weights: &[f32]) {
        match self.network_mut() {
            Some(network) => network.set_weights(weights),
            None => assert!(weights.is_empty(), "a correction without weights was given some"),
        }
    }
    /// Writes the weights by name to a file that the correction's config can name.
    ///
    /// # Errors
    /// When there are none, or the file cannot be written.
    fn save_weights(&self, path: &Path) -> anyhow::Result<()> {
        match self.network() {
            Some(network) => network.save_weights(path),
            None => anyhow::bail!("{} cannot be written: the correction has no weights", path.display()),
        }
    }
}

family! {
    /// Every correction that a config can name.
    CorrectionSpec builds Box<dyn Correction> {
        OutputResidual(output_residual::OutputResidualSpec),
        Feature(feature::FeatureSpec),
        Projected(projection::ProjectedSpec),
    }
}
