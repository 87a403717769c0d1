//! One control interval of a particle model: what stays the same over its substeps, and what comes before and after them.
use super::{ParticleModel, ParticleState};
use crate::graph::{Graph, Nodes};
use crate::model::correction::Outcome;
use crate::model::law::{History, Rate, Traced, View};
use crate::model::net::Wanted;
use crate::state::{Control, Particles, Pose, Twist};
use glam::DVec3;

/// What stays the same over the substeps of one interval.
pub(super) struct Interval<'a> {
    pub(super) model: &'a ParticleModel,
    pub(super) state: &'a ParticleState,
    pub(super) control: &'a Control,
    /// Velocity of each part.
    pub(super) twists: Vec<Twist>,
    /// Number of substeps K.
    pub(super) substeps: usize,
    /// Duration of a substep h \[s\].
    pub(super) h: f64,
    /// Fraction of the velocity kept over one substep.
    pub(super) keep: f64,
    /// What the laws of [`Rate::Step`] saw, where there are any, and their summed acceleration.
    pub(super) held: Option<Held>,
}

/// A graph, and accelerations \[m/s²\].
pub(super) type Held = (Graph, Vec<DVec3>);

impl ParticleModel {
    /// K of a control step of `interval` T \[s\]: `substeps`, or `⌈T/(stability h)⌉` where that is more, h the longest substep that every
    /// law bears.
    pub fn substeps(&self, interval: f64) -> usize {
        let Some(share) = self.stability else { return self.substeps };
        let stable = self.laws(Rate::Substep).map(|(law, _)| law.stable()).fold(f64::INFINITY, f64::min);
        self.substeps.max((interval / (share * stable)).ceil() as usize)
    }
}

impl<'a> Interval<'a> {
    /// With what the laws of [`Rate::Step`] say.
    pub(super) fn new(model: &'a ParticleModel, state: &'a ParticleState, control: &'a Control) -> Self {
        let mut interval = Self::unasked(model, state, control);
        interval.hold();
        interval
    }

    /// With a held acceleration of zero, for who does not look at where the substeps lead.
    pub(super) fn unasked(model: &'a ParticleModel, state: &'a ParticleState, control: &'a Control) -> Self {
        let mut interval = Self::unconnected(model, state, control);
        let particles = &state.particles;
        let still = || (interval.connect(particles), vec![DVec3::ZERO; particles.len()]);
        interval.held = model.laws(Rate::Step).next().map(|_| still());
        interval
    }

    fn unconnected(model: &'a ParticleModel, state: &'a ParticleState, control: &'a Control) -> Self {
        let path = state.poses.iter().zip(&control.poses);
        let substeps = model.substeps(state.interval);
        Self {
            substeps,
            model,
            state,
            control,
            twists: path.map(|(from, to)| from.twist_to(to, state.interval)).collect(),
            h: state.interval / substeps as f64,
            keep: model.keep.powf((substeps as f64).recip()),
            held: None,
        }
    }

    /// With what the laws of [`Rate::Step`] saw and said.
    pub(super) fn holding(
        model: &'a ParticleModel,
        state: &'a ParticleState,
        control: &'a Control,
        held: Held,
    ) -> Self {
        Self { held: Some(held), ..Self::unconnected(model, state, control) }
    }

    /// Asks the laws of [`Rate::Step`] of `model`, which is the interval's, each for its trace.
    pub(super) fn trace<'m>(&mut self, model: &'m ParticleModel, wanted: Wanted) -> Vec<Option<Traced<'m>>> {
        let Some((graph, mut acceleration)) = self.held.take() else { return Vec::new() };
        let view = self.view(&self.state.particles, &graph, &self.control.poses);
        let traced = model.laws(Rate::Step).map(|(law, _)| law.trace(&view, wanted, &mut acceleration)).collect();
        self.held = Some((graph, acceleration));
        traced
    }

    /// Asks the laws of [`Rate::Step`].
    pub(super) fn hold(&mut self) {
        let Some((graph, mut acceleration)) = self.held.take() else { return };
        let view = self.view(&self.state.particles, &graph, &self.control.poses);
        self.model.laws(Rate::Step).for_each(|(law, _)| law.accelerate(&view, &mut acceleration));
        self.held = Some((graph, acceleration));
    }

    /// The graph over particles and the tool at the end of the interval.
    fn connect(&self, particles: &Particles) -> Graph {
        let ParticleState { skeleton, walls, tool, poses, interval, .. } = self.state;
        let nodes = Nodes::gather(particles, skeleton, walls, tool, poses, &self.control.poses, *interval);
        self.model.graph.as_ref().expect("a model whose parts look at a graph has one").connect(nodes)
    }

    /// The state that it leads to.
    pub(super) fn end(&self) -> ParticleState {
        let (particles, histories) = self.model.integrator.advance(self, None);
        self.state.next(self.correct(particles, None), histories, self.control)
    }

    /// Gives `ask` what a correction of `predicted` may look at.
    pub(super) fn outcome<R>(&self, predicted: &Particles, ask: impl FnOnce(&Outcome<'_>) -> R) -> R {
        let graph = Graph::default();
        let before = self.view(&self.state.particles, &graph, &self.control.poses);
        ask(&Outcome { before, predicted, connect: &|particles| self.connect(particles) })
    }

    /// The particles at the end, from what the laws predict; what each correction was given goes onto the tape, where there is one.
    pub(super) fn correct(&self, mut predicted: Particles, mut tape: Option<&mut Vec<Particles>>) -> Particles {
        for (correction, _) in self.model.corrections() {
            let corrected = self.outcome(&predicted, |outcome| correction.correct(outcome));
            let given = std::mem::replace(&mut predicted, corrected);
            if let Some(tape) = &mut tape {
                tape.push(given);
            }
        }
        predicted
    }

    /// What a law sees that remembers nothing.
    pub(super) fn view<'b>(&'b self, particles: &'b Particles, graph: &'b Graph, poses: &'b [Pose]) -> View<'b> {
        let ParticleState { past, body, walls, constants, tool, interval, .. } = self.state;
        let twists = &self.twists;
        View {
            particles,
            past,
            body,
            walls,
            constants,
            graph,
            tool,
            poses,
            twists,
            interval: *interval,
            history: History::NONE,
        }
    }

    /// How far the tool has come at the end of substep `k`, of its way.
    pub(super) fn fraction(&self, k: usize) -> f64 {
        (k + 1) as f64 / self.substeps as f64
    }

    /// Writes the tool's poses after a `fraction` of its way.
    pub(super) fn place(&self, fraction: f64, poses: &mut Vec<Pose>) {
        let path = self.state.poses.iter().zip(&self.control.poses);
        poses.clear();
        poses.extend(path.map(|(from, to)| from.toward(to, fraction)));
    }
}
