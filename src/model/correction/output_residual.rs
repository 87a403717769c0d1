//! A network that sees what the laws predict, and adds what they miss.
use super::motion::{Motion, add, add_tool};
use super::{Correction, Outcome, OutcomeGrad};
use crate::model::law::{Law, LearnedSpec, View};
use crate::state::{Particles, ParticlesGrad};
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Config of [`OutputResidual`]: that of the network.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct OutputResidualSpec(pub LearnedSpec);

impl OutputResidualSpec {
    pub(crate) fn build(self) -> anyhow::Result<OutputResidual> {
        Ok(OutputResidual::of(Box::new(self.0.build()?)))
    }
}

/// `x' = x̂ + scale · net`, `v' = v̂ + scale · net / Δt` of the prediction (x̂, v̂): the residual physics of Ajay et al. 2018 and Zeng
/// et al. 2019, with a graph network.
///
/// The network sees the predicted places with the mean velocity of the step, `(x̂ − x)/Δt`, the tool at the step's end, and, where
/// `history` is more than one, the velocities at the step's start and before. An untrained network changes nothing.
pub struct OutputResidual(Motion);

impl OutputResidual {
    /// What `law` adds when it is asked about the prediction, its acceleration held over the step.
    pub fn of(law: Box<dyn Law>) -> Self {
        Self(Motion(law))
    }
}

/// What the network sees.
struct Seen {
    particles: Particles,
    past: Vec<Vec<DVec3>>,
}

impl Seen {
    fn of(Outcome { before, predicted, .. }: &Outcome<'_>) -> Self {
        let pairs = predicted.positions.iter().zip(&before.particles.positions);
        let velocities = pairs.map(|(to, from)| (*to - *from) / before.interval).collect();
        Self {
            particles: Particles { positions: predicted.positions.clone(), velocities },
            past: std::iter::once(&before.particles.velocities).chain(before.past).cloned().collect(),
        }
    }
}

impl Correction for OutputResidual {
    fn network(&self) -> Option<&dyn Law> {
        Some(self.0.0.as_ref())
    }

    fn network_mut(&mut self) -> Option<&mut dyn Law> {
        Some(self.0.0.as_mut())
    }

    fn correct(&self, outcome: &Outcome<'_>) -> Particles {
        let Seen { particles, past } = &Seen::of(outcome);
        let graph = &(outcome.connect)(particles);
        let push = self.0.of(&View { particles, past, graph, ..outcome.before });
        let mut out = outcome.predicted.clone();
        add(&mut out.positions, &push, outcome.before.interval);
        add(&mut out.velocities, &push, 1.0);
        out
    }

    fn correct_vjp(&self, outcome: &Outcome<'_>, at: &ParticlesGrad, grad: &mut OutcomeGrad<'_>) {
        let Seen { particles, past } = &Seen::of(outcome);
        let graph = &(outcome.connect)(particles);
        let inner = self.0.pull(&View { particles, past, graph, ..outcome.before }, at, grad.before.weights);
        let OutcomeGrad { before, predicted } = grad;
        let per_step = outcome.before.interval.recip();
        for rows in [&at.positions, &inner.particles.positions] {
            add(&mut predicted.positions, rows, 1.0);
        }
        add(&mut predicted.positions, &inner.particles.velocities, per_step);
        add(&mut predicted.velocities, &at.velocities, 1.0);
        add(&mut before.particles.positions, &inner.particles.velocities, -per_step);
        let starts = std::iter::once(&mut before.particles.velocities).chain(&mut before.past);
        starts.zip(&inner.past).for_each(|(sum, rows)| add(sum, rows, 1.0));
        add_tool(before, &inner);
    }
}
