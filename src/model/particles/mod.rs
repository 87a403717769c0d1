//! Particles under a list of laws, integrated by semi-implicit Euler, with a hand-written adjoint.
//!
//! One control step of duration T is K substeps of `h = T/K`; laws of [`Rate::Step`] are asked once, with the tool at the end of
//! the step, and their acceleration is held; laws of [`Rate::Substep`] are asked in every substep k with the tool a fraction
//! `(k + 1)/K` of its way: `v ← keep^{1/K} v + h Σ a`, then `x ← x + h v`. Written, learned and hybrid models differ only in
//! their list. A rigid body's particles go where its nearest rigid motion takes them, in every substep.
use super::law::{Law, LawSpec, Rate};
use super::{Adjoint, Dynamics};
use crate::graph::{GraphPolicy, GraphSpec};
use crate::state::{Control, Particles, Scene};
use anyhow::{Context, ensure};
use interval::Interval;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::path::Path;

mod adjoint;
mod interval;
mod neighbours;
mod rigid;
mod state;

pub use state::ParticleState;

/// Config of [`ParticleModel`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ParticlesSpec {
    /// Substeps K of one control step \[1\].
    #[schemars(range(min = 1))]
    pub substeps: usize,
    /// Fraction of the velocity kept over one control step where nothing acts; 1 has no drag, 0 no inertia \[1\].
    #[schemars(range(min = 0.0, max = 1.0))]
    pub keep: f64,
    /// Numbers of the bodies that keep their shape.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub rigid: Vec<u32>,
    /// Graph for the laws asked once a control step; needed only where there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub graph: Option<GraphSpec>,
    /// Laws whose accelerations add up.
    #[serde(default)]
    pub laws: Vec<LawSpec>,
}

impl ParticlesSpec {
    pub(crate) fn build(self) -> anyhow::Result<ParticleModel> {
        let place = |(i, law): (usize, LawSpec)| law.build().with_context(|| format!("in dynamics.laws[{i}]"));
        let names = self.laws.iter().map(LawSpec::called).collect();
        let laws = self.laws.into_iter().enumerate().map(place).collect::<Result<_, _>>()?;
        let graph = self.graph.map(GraphSpec::build).transpose()?;
        Ok(ParticleModel { rigid: self.rigid, names, ..ParticleModel::new(self.substeps, self.keep, graph, laws)? })
    }
}

/// A model that moves particles by the sum of its laws.
pub struct ParticleModel {
    substeps: usize,
    keep: f64,
    rigid: Vec<u32>,
    graph: Option<Box<dyn GraphPolicy>>,
    laws: Vec<Box<dyn Law>>,
    /// Number of velocities before the present one that some law looks at.
    memory: usize,
    /// What each law is addressed by: its place in the list where no config named it.
    names: Vec<String>,
    /// Where what each law owns lies in what the model owns.
    spans: Vec<Spans>,
}

/// Where a law's weights and constants lie in the model's.
struct Spans {
    weights: Range<usize>,
    constants: Range<usize>,
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
        let mut end = (0, 1);
        let spans = laws.iter().map(|law| {
            let start = end;
            end = (start.0 + law.weights().len(), start.1 + law.constants().len());
            Spans { weights: start.0..end.0, constants: start.1..end.1 }
        });
        let spans = spans.collect();
        let names = (0..laws.len()).map(|place| place.to_string()).collect();
        let memory = laws.iter().map(|law| law.memory()).max().unwrap_or(0);
        Ok(Self { substeps, keep, rigid: Vec::new(), graph, laws, memory, names, spans })
    }

    /// The laws of one rate, each with its place in what the model owns.
    fn laws(&self, rate: Rate) -> impl Iterator<Item = (&dyn Law, &Spans)> {
        let laws = self.laws.iter().zip(&self.spans).map(|(law, span)| (&**law, span));
        laws.filter(move |(law, _)| law.rate() == rate)
    }
}

impl Dynamics for ParticleModel {
    type State = ParticleState;

    fn accepts(&self, scene: &Scene) -> anyhow::Result<()> {
        let (poses, parts) = (scene.poses.len(), scene.tool.parts.len());
        ensure!(poses == parts, "the scene gives {poses} tool poses for a tool of {parts} parts");
        ensure!(scene.interval > 0.0, "the scene's control interval must be positive, got {} s", scene.interval);
        let (positions, velocities) = (scene.particles.positions.len(), scene.particles.velocities.len());
        ensure!(positions == velocities, "the scene gives {positions} positions but {velocities} velocities");
        let bodies = scene.body.len();
        ensure!(positions == bodies, "the scene gives {positions} particles but the bodies of {bodies}");
        ensure!(scene.particles.is_finite(), "a particle's position or velocity in the scene is not a finite number");
        self.laws.iter().try_for_each(|law| law.accepts(scene))
    }

    fn encode(&self, scene: &Scene) -> ParticleState {
        ParticleState::new(scene, self.graph.as_deref(), &self.rigid, self.memory)
    }

    fn step(&self, state: &ParticleState, control: &Control) -> ParticleState {
        let interval = Interval::new(self, state, control);
        let particles = interval.advance(None);
        state.next(particles, control)
    }

    fn decode(&self, state: &ParticleState) -> Particles {
        state.decode()
    }

    fn adjoint(&self) -> Option<&dyn Adjoint<ParticleState>> {
        Some(self)
    }

    fn weights(&self) -> Vec<f32> {
        self.laws.iter().flat_map(|law| law.weights()).collect()
    }

    fn set_weights(&mut self, weights: &[f32]) {
        assert_eq!(weights.len(), self.spans.last().map_or(0, |s| s.weights.end), "weights of another architecture");
        for (law, span) in self.laws.iter_mut().zip(&self.spans) {
            law.set_weights(&weights[span.weights.clone()]);
        }
    }

    fn save_weights(&self, path: &Path) -> anyhow::Result<()> {
        let mut learned = self.laws.iter().zip(&self.spans).filter(|(_, span)| !span.weights.is_empty());
        match (learned.next(), learned.next()) {
            (Some((law, _)), None) => law.save_weights(path),
            (None, _) => anyhow::bail!("{} cannot be written: no law has weights", path.display()),
            _ => anyhow::bail!("{} cannot hold the weights of several laws; train one at a time", path.display()),
        }
    }
}
