//! What the laws of every substep say to each other's particles at the start of a control step.
use super::interval::Interval;
use super::neighbours::Neighbours;
use super::{ParticleModel, ParticleState, Spans};
use crate::model::law::{Law, Message, Rate, View};
use crate::state::{Control, Scene};

impl ParticleModel {
    /// Calls `ask` with every law of [`Rate::Substep`], its place in what the model owns, and what it sees, the tool where
    /// it starts.
    fn at_start(&self, scene: &Scene, control: &Control, mut ask: impl FnMut(&dyn Law, &Spans, &View<'_>)) {
        let state = ParticleState::new(scene, self.graph.as_deref(), &self.rigid, self.memory);
        let interval = Interval::new(self, &state, control);
        let laws: Vec<(&dyn Law, &Spans)> = self.laws(Rate::Substep).collect();
        let mut neighbours =
            Neighbours::new(laws.iter().map(|(law, _)| law.reach()).collect(), &state.particles.positions);
        let lists = neighbours.at(&state.particles.positions);
        for (law, spans) in laws {
            ask(law, spans, &interval.view(&state.particles, lists.of(law.reach()), &state.poses));
        }
    }

    pub(super) fn said(&self, scene: &Scene, control: &Control) -> Vec<Message> {
        let mut all = Vec::new();
        self.at_start(scene, control, |law, _, view| all.extend(law.messages(view)));
        all
    }

    pub(super) fn said_vjp(&self, scene: &Scene, control: &Control, mut at: &[[f64; 2]], weights: &mut [f32]) {
        self.at_start(scene, control, |law, spans, view| {
            let (own, others) = at.split_at(law.messages(view).len());
            law.messages_vjp(view, own, &mut weights[spans.weights.clone()]);
            at = others;
        });
    }
}
