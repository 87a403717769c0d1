//! A network as a law: what moves a particle beyond what anyone wrote down.
use super::frame::{Frame, FrameSpec, Seen};
use super::{Law, Rate, Traced, View, ViewGrad};
use crate::graph::kinds_named;
use crate::model::net::{self, Aggregation, Architecture, Features, Links, Network, Precision, Sharing, Wanted};
use crate::state::{MEMORY, ParticlesGrad, PoseGrad, Scene, Twist};
use anyhow::ensure;
use glam::DVec3;
use indexmap::IndexMap;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Config of [`Learned`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LearnedSpec {
    /// Width of every hidden layer.
    #[schemars(range(min = 1, max = 1024))]
    pub width: usize,
    /// Rounds of message passing.
    #[schemars(range(min = 1, max = 16))]
    pub rounds: usize,
    /// Whether rounds share weights.
    pub sharing: Sharing,
    /// How the messages that a node receives become one.
    #[serde(default)]
    pub aggregation: Aggregation,
    /// Number of velocities of each particle that the network sees: the present one, and those of the control steps before.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    #[schemars(range(min = 1, max = 9))]
    pub history: usize,
    /// Number of bodies that the network tells apart by their numbers; with 1 all are alike to it.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    #[schemars(range(min = 1, max = 64))]
    pub bodies: usize,
    /// Constants of the scene that the network is told, by their path in its config, each with the range that becomes −1 to 1.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub constants: IndexMap<String, [f64; 2]>,
    /// Names of the edge kinds that carry messages.
    pub edges: Vec<String>,
    /// Whether all kinds have one edge network, which a flag tells the kind, in place of one each.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub shared_edges: bool,
    /// Whether what rounds and decoder read of a node is brought to mean zero and variance one (Ba, Kiros & Hinton 2016).
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub layer_norm: bool,
    /// Distance at which a message has faded to zero, at most the graph's radius \[m\].
    #[schemars(range(min = 1e-6))]
    pub radius: f64,
    /// Displacement in a control step that counts as one, for velocities and for the output \[m\].
    #[schemars(range(min = 1e-9))]
    pub scale: f64,
    /// The axes in which the network sees the scene.
    #[serde(default)]
    pub frame: FrameSpec,
    /// Numbers that predictions are computed in.
    #[serde(default, skip_serializing_if = "Precision::is_default")]
    pub precision: Precision,
    /// Seed of the untrained weights.
    pub seed: u64,
    /// File of trained weights (safetensors).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub weights: Option<PathBuf>,
}

impl LearnedSpec {
    /// The law, with the weights of the file or untrained.
    ///
    /// # Errors
    /// A sentence naming the impossible key, or what is wrong with the file of weights.
    pub fn build(self) -> anyhow::Result<Learned> {
        ensure!((1..=1024).contains(&self.width), "width must be between 1 and 1024, got {}", self.width);
        ensure!((1..=16).contains(&self.rounds), "rounds must be between 1 and 16, got {}", self.rounds);
        let history = 1..=1 + MEMORY;
        ensure!(history.contains(&self.history), "history must be between 1 and {}, got {}", 1 + MEMORY, self.history);
        ensure!((1..=64).contains(&self.bodies), "bodies must be between 1 and 64, got {}", self.bodies);
        for (key, value) in [("radius", self.radius), ("scale", self.scale)] {
            ensure!(value > 0.0 && value.is_finite(), "{key} must be a positive length, got {value}");
        }
        for (path, [low, high]) in &self.constants {
            let range = low < high && (high - low).is_finite();
            ensure!(range, "constants gives {path} the range [{low}, {high}]; it must be [low, high] with low < high");
        }
        let kinds = kinds_named("edges", &self.edges)?;
        for (i, kind) in kinds.iter().enumerate() {
            ensure!(!kinds[..i].contains(kind), "edges names {:?} twice", self.edges[i]);
        }
        let architecture = Architecture {
            width: self.width,
            rounds: self.rounds,
            sharing: self.sharing,
            aggregation: self.aggregation,
            history: self.history,
            bodies: self.bodies,
            constants: self.constants.keys().cloned().collect(),
            edges: self.edges,
            shared_edges: self.shared_edges,
            layer_norm: self.layer_norm,
        };
        let mut network = Network::new(architecture, self.seed).in_precision(self.precision);
        if let Some(path) = &self.weights {
            network.load(path)?;
        }
        let Self { history, bodies, constants, radius, scale, frame, .. } = self;
        Ok(Learned { network, features: Features { kinds, history, bodies, constants, radius, scale }, frame })
    }
}

/// `a = (scale/Δt²) · network(graph)`: with one substep and no kept velocity a particle moves by `scale · network`.
///
/// Held over a control interval Δt \[s\]; output (N, 3). An untrained network adds exactly zero.
#[derive(Clone, Debug)]
pub struct Learned {
    network: Network,
    features: Features,
    frame: FrameSpec,
}

impl Learned {
    /// Acceleration that an output of one stands for \[m/s²\].
    fn unit(&self, view: &View<'_>) -> f64 {
        self.features.scale / view.interval.powi(2)
    }
}

/// What the network said about a view in the law's frame, and who heard whom.
struct Looked<'a> {
    network: net::Traced<'a>,
    links: Vec<Arc<Links>>,
}

impl Learned {
    fn look(&self, inside: &View<'_>, wanted: Wanted) -> Looked<'_> {
        let input = self.features.input(inside);
        let links = input.edges.iter().map(|e| Arc::clone(&e.links)).collect();
        Looked { network: self.network.trace(input, wanted), links }
    }
}

impl Looked<'_> {
    /// See [`Law::accelerate_vjp`], at the view that was looked at.
    fn pull(self, law: &Learned, view: &View<'_>, out: &[DVec3], grad: &mut ViewGrad<'_>) {
        let (unit, frame) = (law.unit(view), Frame::of(law.frame, view));
        let mut output = vec![DVec3::ZERO; view.particles.len()];
        frame.add(unit, self.network.output(), &mut output);
        let at_output: Vec<f32> = out.iter().flat_map(|g| frame.enter(unit * *g).as_vec3().to_array()).collect();
        let at_input = self.network.pull(&at_output, grad.weights);
        let mut inner = ViewGrad {
            particles: ParticlesGrad::zero(view.particles.len()),
            past: vec![vec![DVec3::ZERO; view.particles.len()]; view.past.len()],
            poses: vec![PoseGrad::default(); view.poses.len()],
            twists: vec![Twist::default(); view.twists.len()],
            history: Vec::new(),
            weights: &mut [],
        };
        let seen = frame.see(view);
        let normals = law.features.pull(&within(view, &seen), &self.links, &at_input, &mut inner);
        frame.pull(view, &output, out, &inner, &normals, grad);
    }
}

impl Law for Learned {
    fn rate(&self) -> Rate {
        Rate::Step
    }

    fn accepts(&self, scene: &Scene) -> anyhow::Result<()> {
        let (told, last) = (self.features.bodies, scene.body.iter().max().map_or(0, |number| *number as usize));
        ensure!(
            told == 1 || last < told,
            "the scene's bodies are numbered up to {last}, but the network tells {told} apart; set `bodies` of the learned law to {}",
            last + 1
        );
        for path in self.features.constants.keys() {
            let known = scene.constants.keys().map(String::as_str).collect::<Vec<_>>().join(", ");
            ensure!(
                scene.constants.contains_key(path),
                "the network is told {path}, which this scene does not tell (it tells {}); let the dataset `vary` it",
                if known.is_empty() { "nothing" } else { &known }
            );
        }
        Ok(())
    }

    fn memory(&self) -> usize {
        self.features.history - 1
    }

    fn reach(&self) -> f64 {
        self.features.radius
    }

    fn accelerate(&self, view: &View<'_>, out: &mut [DVec3]) {
        // A hybrid's written laws are identified before its network is trained: what is exactly zero need not be computed.
        if self.network.is_silent() {
            return;
        }
        let (unit, frame) = (self.unit(view), Frame::of(self.frame, view));
        let seen = frame.see(view);
        let rows = self.network.forward(self.features.input(&within(view, &seen)));
        frame.add(unit, &rows, out);
    }

    fn accelerate_vjp(&self, view: &View<'_>, out: &[DVec3], grad: &mut ViewGrad<'_>) {
        let wanted = Wanted::of(grad.weights);
        let frame = Frame::of(self.frame, view);
        self.look(&within(view, &frame.see(view)), wanted).pull(self, view, out, grad);
    }

    fn trace(&self, view: &View<'_>, wanted: Wanted, out: &mut [DVec3]) -> Option<Traced<'_>> {
        if self.network.is_silent() {
            return None;
        }
        let (unit, frame) = (self.unit(view), Frame::of(self.frame, view));
        let looked = self.look(&within(view, &frame.see(view)), wanted);
        frame.add(unit, looked.network.output(), out);
        Some(Traced {
            bytes: looked.network.bytes(),
            pull: Box::new(|view, out, grad| looked.pull(self, view, out, grad)),
        })
    }

    fn weights(&self) -> Vec<f32> {
        self.network.weights()
    }

    fn matrices(&self) -> Vec<(String, usize)> {
        self.network.matrices()
    }

    fn set_weights(&mut self, weights: &[f32]) {
        self.network.set_weights(weights);
    }

    fn save_weights(&self, path: &Path) -> anyhow::Result<()> {
        self.network.save(path)
    }
}

/// The same view with particles and tool as `seen` in a frame; which nodes an edge joins does not depend on axes.
fn within<'a>(view: &View<'a>, seen: &'a Seen) -> View<'a> {
    let Seen { particles, past, walls, poses, twists } = seen;
    View { particles, past, walls, poses, twists, ..*view }
}

fn one() -> usize {
    1
}

fn is_one(count: &usize) -> bool {
    *count == one()
}
