//! A network that moves particles by itself, and is told how the laws would move them.
use super::motion::{Motion, add, add_tool};
use super::{Correction, Outcome, OutcomeGrad};
use crate::model::law::{Law, LearnedSpec, View};
use crate::state::{MEMORY, Particles, ParticlesGrad};
use anyhow::ensure;
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Config of [`Feature`]: that of the network.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct FeatureSpec(pub LearnedSpec);

impl FeatureSpec {
    pub(crate) fn build(self) -> anyhow::Result<Feature> {
        let history = self.0.history;
        ensure!((1..=MEMORY).contains(&history), "history must be between 1 and {MEMORY}, got {history}");
        // The prediction is one more velocity that the network sees.
        Ok(Feature::of(Box::new(LearnedSpec { history: history + 1, ..self.0 }.build()?)))
    }
}

/// `x' = x + scale · net(…, x̂ − x)`, `v' = (x' − x)/Δt`: the network's input is that of a network alone at the start of the step and,
/// for every particle, the displacement that the laws predict; its output is the motion.
///
/// The displacement stands among the velocities that the network sees, behind the present one. An untrained network predicts that
/// nothing moves.
pub struct Feature(Motion);

impl Feature {
    /// The motion that `law` gives, its acceleration held over the step, where the predicted mean velocity of the step is the first of
    /// the past velocities that it looks at.
    pub fn of(law: Box<dyn Law>) -> Self {
        Self(Motion(law))
    }

    /// The velocities that the network sees behind the present one: the predicted mean of the step, then those of the past.
    fn past(Outcome { before, predicted, .. }: &Outcome<'_>) -> Vec<Vec<DVec3>> {
        let pairs = predicted.positions.iter().zip(&before.particles.positions);
        let mean = pairs.map(|(to, from)| (*to - *from) / before.interval).collect();
        std::iter::once(mean).chain(before.past.iter().cloned()).collect()
    }
}

impl Correction for Feature {
    fn network(&self) -> Option<&dyn Law> {
        Some(self.0.0.as_ref())
    }

    fn network_mut(&mut self) -> Option<&mut dyn Law> {
        Some(self.0.0.as_mut())
    }

    fn correct(&self, outcome: &Outcome<'_>) -> Particles {
        let (past, graph) = (&Self::past(outcome), &(outcome.connect)(outcome.before.particles));
        let velocities = self.0.of(&View { past, graph, ..outcome.before });
        let mut positions = outcome.before.particles.positions.clone();
        add(&mut positions, &velocities, outcome.before.interval);
        Particles { positions, velocities }
    }

    fn correct_vjp(&self, outcome: &Outcome<'_>, at: &ParticlesGrad, grad: &mut OutcomeGrad<'_>) {
        let (past, graph) = (&Self::past(outcome), &(outcome.connect)(outcome.before.particles));
        let inner = self.0.pull(&View { past, graph, ..outcome.before }, at, grad.before.weights);
        let OutcomeGrad { before, predicted } = grad;
        let per_step = outcome.before.interval.recip();
        let (mean, past) = inner.past.split_first().expect("the prediction is seen");
        for rows in [&at.positions, &inner.particles.positions] {
            add(&mut before.particles.positions, rows, 1.0);
        }
        add(&mut before.particles.positions, mean, -per_step);
        add(&mut before.particles.velocities, &inner.particles.velocities, 1.0);
        add(&mut predicted.positions, mean, per_step);
        before.past.iter_mut().zip(past).for_each(|(sum, rows)| add(sum, rows, 1.0));
        add_tool(before, &inner);
    }
}
