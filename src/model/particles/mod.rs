//! Particles under a list of laws, integrated over substeps, with a hand-written adjoint.
//!
//! One control step of duration T is K substeps of `h = T/K`; laws of [`Rate::Step`] are asked once, with the tool at the end of
//! the step, and their acceleration is held; laws of [`Rate::Substep`] are asked in every substep k with the tool a fraction
//! `(k + 1)/K` of its way: by default `v ← keep^{1/K} v + h Σ a`, then `x ← x + h v`, see [`IntegratorSpec`]. Written, learned and
//! hybrid models differ only in their list. A rigid body's particles go where its nearest rigid motion takes them, in every
//! substep. K is as configured, or as the stiffest law needs it. What the substeps lead to, corrections may change at the end of the
//! control step, one after the other.
use super::correction::Correction;
use super::law::{History, Law, Message, Rate};
use super::{Adjoint, Checkpoints, Dynamics};
use crate::graph::GraphPolicy;
use crate::state::{Control, Particles, Scene};
use anyhow::ensure;
use integrator::Integrator;
use interval::Interval;
use std::ops::Range;
use std::path::Path;

mod adjoint;
mod backward;
mod integrator;
mod interval;
mod messages;
mod neighbours;
mod rigid;
mod spec;
mod state;
mod substeps;
mod tape;

pub use integrator::IntegratorSpec;
pub use spec::ParticlesSpec;
pub use state::ParticleState;

/// Most substeps of a control step.
const SUBSTEPS: usize = 100_000;

/// A model that moves particles by the sum of its laws.
pub struct ParticleModel {
    substeps: usize,
    stability: Option<f64>,
    keep: f64,
    integrator: Box<dyn Integrator>,
    checkpoints: Checkpoints,
    rigid: Vec<u32>,
    graph: Option<Box<dyn GraphPolicy>>,
    laws: Vec<Box<dyn Law>>,
    corrections: Vec<Box<dyn Correction>>,
    /// Number of velocities before the present one that some law or correction looks at.
    memory: usize,
    /// What each law is addressed by: its place in the list where no config named it.
    names: Vec<String>,
    /// Where what each law owns lies in what the model owns.
    spans: Vec<Spans>,
    /// Where each correction's weights lie, behind those of the laws.
    corrected: Vec<Range<usize>>,
}

/// Where what a law owns lies in what the model owns.
struct Spans {
    weights: Range<usize>,
    constants: Range<usize>,
    /// Its place in the list of laws, and what it remembers in that of memories.
    place: usize,
}

impl ParticleModel {
    /// A model of `substeps` K and `keep` (see [`ParticlesSpec`]) under `laws`, with the graph that laws of [`Rate::Step`] see.
    ///
    /// # Errors
    /// When K is zero, `keep` is outside \[0, 1\], or a law of [`Rate::Step`] has no graph.
    pub fn new(
        substeps: usize,
        keep: f64,
        graph: Option<Box<dyn GraphPolicy>>,
        laws: Vec<Box<dyn Law>>,
    ) -> anyhow::Result<Self> {
        ensure!(substeps > 0, "dynamics.substeps must be at least 1");
        ensure!((0.0..=1.0).contains(&keep), "dynamics.keep must lie in [0, 1], got {keep}");
        ensure!(
            graph.is_some() || laws.iter().all(|law| law.rate() == Rate::Substep),
            "dynamics.laws holds a law that is asked once a control step: it needs a graph, add [dynamics.graph]"
        );
        // The first constant is `keep`.
        let constants = spans(1, laws.iter().map(|law| law.constants().len()));
        let own = spans(0, laws.iter().map(|law| law.weights().len())).into_iter().zip(constants);
        let spans = own.enumerate().map(|(place, (weights, constants))| Spans { weights, constants, place }).collect();
        let names = (0..laws.len()).map(|place| place.to_string()).collect();
        let memory = laws.iter().map(|law| law.memory()).max().unwrap_or(0);
        let (rigid, corrections, corrected) = (Vec::new(), Vec::new(), Vec::new());
        let integrator = IntegratorSpec::default().build();
        let (checkpoints, stability) = (Checkpoints::default(), None);
        Ok(Self {
            substeps,
            stability,
            keep,
            integrator,
            checkpoints,
            rigid,
            graph,
            laws,
            corrections,
            memory,
            names,
            spans,
            corrected,
        })
    }

    /// The same model, in as many more substeps as the stiffest law needs, `stability` being their share of the longest that it bears.
    ///
    /// # Errors
    /// When that is less than a thousandth.
    pub fn stable(self, stability: Option<f64>) -> anyhow::Result<Self> {
        let share = stability.unwrap_or(1.0);
        ensure!(
            share >= 1e-3 && share.is_finite(),
            "dynamics.stability must be at least 0.001 and finite, got {share}"
        );
        Ok(Self { stability, ..self })
    }

    /// The same model, taken through its substeps by `integrator`.
    ///
    /// # Errors
    /// When that cannot move rigid bodies, or does not move at all without inertia.
    pub fn integrated(self, integrator: IntegratorSpec) -> anyhow::Result<Self> {
        if integrator == IntegratorSpec::VelocityVerlet {
            ensure!(
                self.rigid.is_empty(),
                "dynamics.rigid names bodies that keep their shape, which dynamics.integrator = \"velocity_verlet\" cannot move; leave \
                 one of them out"
            );
            ensure!(
                self.keep > 0.0,
                "dynamics.keep must be above 0 where dynamics.integrator is \"velocity_verlet\": without inertia nothing moves"
            );
        }
        Ok(Self { integrator: integrator.build(), ..self })
    }

    /// The same model, its predictions changed by `corrections` at the end of every control step, in their order.
    ///
    /// # Errors
    /// When a correction asks for a graph and there is none.
    pub fn corrected(self, corrections: Vec<Box<dyn Correction>>) -> anyhow::Result<Self> {
        ensure!(
            self.graph.is_some() || !corrections.iter().any(|c| c.draws()),
            "dynamics.corrections holds a network: it needs a graph, add [dynamics.graph]"
        );
        let memory = corrections.iter().map(|c| c.memory()).fold(self.memory, usize::max);
        let laws = self.spans.last().map_or(0, |span| span.weights.end);
        let corrected = spans(laws, corrections.iter().map(|c| c.weights().len()));
        Ok(Self { corrections, memory, corrected, ..self })
    }

    /// The laws of one rate, each with its place in what the model owns.
    fn laws(&self, rate: Rate) -> impl Iterator<Item = (&dyn Law, &Spans)> {
        let laws = self.laws.iter().zip(&self.spans).map(|(law, span)| (&**law, span));
        laws.filter(move |(law, _)| law.rate() == rate)
    }

    /// The corrections, each with its place in the model's weights.
    fn corrections(&self) -> impl DoubleEndedIterator<Item = (&dyn Correction, &Range<usize>)> + ExactSizeIterator {
        self.corrections.iter().zip(&self.corrected).map(|(correction, span)| (&**correction, span))
    }
}

/// Places of so many numbers each, one after the other from `start`.
fn spans(start: usize, counts: impl Iterator<Item = usize>) -> Vec<Range<usize>> {
    let place = |end: &mut usize, count: usize| {
        *end += count;
        Some(*end - count..*end)
    };
    counts.scan(start, place).collect()
}

impl Dynamics for ParticleModel {
    type State = ParticleState;

    fn accepts(&self, scene: &Scene) -> anyhow::Result<()> {
        scene.check()?;
        ensure!(
            self.substeps(scene.interval) < SUBSTEPS,
            "a control step of {} s would take {SUBSTEPS} substeps or more: a law is too stiff; lower its stiffness or rate, or raise \
             dynamics.stability",
            scene.interval
        );
        self.laws.iter().try_for_each(|law| law.accepts(scene))?;
        self.corrections.iter().try_for_each(|correction| correction.accepts(scene))
    }

    fn encode(&self, scene: &Scene) -> ParticleState {
        let state = ParticleState::new(scene, self.graph.as_deref(), &self.rigid, self.memory);
        let begin = |law: &dyn Law| {
            law.remembers().map_or_else(History::default, |memory| memory.begin(&state.particles, &state.body))
        };
        ParticleState { histories: self.laws.iter().map(|law| begin(law.as_ref())).collect(), ..state }
    }

    fn step(&self, state: &ParticleState, control: &Control) -> ParticleState {
        Interval::new(self, state, control).end()
    }

    fn decode(&self, state: &ParticleState) -> Particles {
        state.decode()
    }

    fn adjoint(&self) -> Option<&dyn Adjoint<ParticleState>> {
        Some(self)
    }

    fn messages(&self, scene: &Scene, control: &Control) -> Vec<Message> {
        self.said(scene, control)
    }

    fn messages_vjp(&self, scene: &Scene, control: &Control, at: &[[f64; 2]], weights: &mut [f32]) {
        self.said_vjp(scene, control, at, weights);
    }

    fn checkpoints(&self) -> Checkpoints {
        self.checkpoints
    }

    fn weights(&self) -> Vec<f32> {
        let corrections = self.corrections.iter().flat_map(|correction| correction.weights());
        self.laws.iter().flat_map(|law| law.weights()).chain(corrections).collect()
    }

    fn matrices(&self) -> Vec<(String, usize)> {
        let corrections = self.corrections.iter().flat_map(|correction| correction.matrices());
        self.laws.iter().flat_map(|law| law.matrices()).chain(corrections).collect()
    }

    fn set_weights(&mut self, weights: &[f32]) {
        let laws = self.spans.last().map_or(0, |span| span.weights.end);
        let count = self.corrected.last().map_or(laws, |span| span.end);
        assert_eq!(weights.len(), count, "weights of another architecture");
        for (law, span) in self.laws.iter_mut().zip(&self.spans) {
            law.set_weights(&weights[span.weights.clone()]);
        }
        for (correction, span) in self.corrections.iter_mut().zip(&self.corrected) {
            correction.set_weights(&weights[span.clone()]);
        }
    }

    fn save_weights(&self, path: &Path) -> anyhow::Result<()> {
        let laws = self.laws.iter().zip(&self.spans).filter(|(_, span)| !span.weights.is_empty());
        let corrections = self.corrections.iter().zip(&self.corrected).filter(|(_, span)| !span.is_empty());
        match (&laws.collect::<Vec<_>>()[..], &corrections.collect::<Vec<_>>()[..]) {
            ([(law, _)], []) => law.save_weights(path),
            ([], [(correction, _)]) => correction.save_weights(path),
            ([], []) => anyhow::bail!("{} cannot be written: no law has weights", path.display()),
            _ => anyhow::bail!("{} cannot hold the weights of several networks; train one at a time", path.display()),
        }
    }
}
