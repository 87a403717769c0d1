//! What fixes a message-passing network's weights: their shapes and names.
use super::Aggregation;
use super::input::{EDGE_FEATURES, NODE_FEATURES};
use super::parameters::{ACTIVE_GAIN, Perceptron, Slots};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Whether the rounds of message passing use the same weights.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Sharing {
    /// One set of weights, used in every round.
    Shared,
    /// A set of weights for each round.
    PerRound,
}

/// What fixes the shapes of all weights; two networks with equal architectures can exchange weights.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Architecture {
    /// Width of every hidden layer.
    pub width: usize,
    /// Rounds of message passing.
    pub rounds: usize,
    /// Whether rounds share weights.
    pub sharing: Sharing,
    /// How messages become one.
    #[serde(default)]
    pub aggregation: Aggregation,
    /// Number of velocities of a particle that are seen.
    #[serde(default = "one")]
    pub history: usize,
    /// Number of bodies told apart; with 1 all are alike.
    #[serde(default = "one")]
    pub bodies: usize,
    /// Constants of the scene that every particle is told, in order.
    #[serde(default)]
    pub constants: Vec<String>,
    /// Names of the edge kinds that have an edge network, in order.
    pub edges: Vec<String>,
    /// Whether all kinds have one edge network, which a flag tells the kind.
    #[serde(default)]
    pub shared_edges: bool,
    /// Whether what rounds and decoder read of a node is brought to mean zero and variance one.
    #[serde(default)]
    pub layer_norm: bool,
}

/// Numbers a node where so many velocities are seen, so many bodies told apart and so many constants told.
pub(super) fn node_features(history: usize, bodies: usize, constants: usize) -> usize {
    NODE_FEATURES + told_apart(bodies) + 3 * (history - 1) + constants
}

/// Numbers of a node that say which of `bodies` it belongs to: none where there is nothing to tell apart.
pub(super) fn told_apart(bodies: usize) -> usize {
    if bodies > 1 { bodies } else { 0 }
}

fn one() -> usize {
    1
}

/// Places of an edge network's three layers; the last has no bias, a constant hidden unit stands in for it.
#[derive(Clone, Debug)]
pub(super) struct EdgeNetwork {
    pub(super) first: (usize, usize),
    pub(super) hidden: (usize, usize),
    pub(super) last: usize,
    /// Row of the first layer that is the kind's flag.
    pub(super) flag: Option<usize>,
}

/// Places of one round's weights.
#[derive(Clone, Debug)]
pub(super) struct Round {
    /// Gain and shift of what the round reads.
    pub(super) norm: Option<(usize, usize)>,
    pub(super) edges: Vec<EdgeNetwork>,
    pub(super) update: Perceptron,
}

/// Where each block finds its weights.
#[derive(Clone, Debug)]
pub(super) struct Layout {
    pub(super) encoder: Perceptron,
    /// One entry a set of weights: a single one when rounds share.
    pub(super) rounds: Vec<Round>,
    /// Gain and shift of what the decoder reads.
    pub(super) norm: Option<(usize, usize)>,
    pub(super) decoder: Perceptron,
}

impl Architecture {
    /// Every weight matrix, and where each block finds its own.
    pub(super) fn layout(&self) -> (Slots, Layout) {
        let w = self.width;
        let mut slots = Slots::default();
        let encoder = slots.perceptron("node", self.node_features(), w, w, 1.0);
        let sets = match self.sharing {
            Sharing::Shared => 1,
            Sharing::PerRound => self.rounds,
        };
        let round = |set: usize| {
            let prefix = match self.sharing {
                Sharing::Shared => String::new(),
                Sharing::PerRound => format!("round.{set}."),
            };
            let norm = self.norm(&mut slots, &prefix);
            let (inputs, kinds) = (2 * w + EDGE_FEATURES, self.edges.len());
            let mut network = |kind: &str, flags: usize| {
                let name = format!("{prefix}edge.{kind}");
                EdgeNetwork {
                    first: slots.layer(&format!("{name}.first"), inputs + flags, w, 1.0),
                    hidden: slots.layer(&format!("{name}.hidden"), w, w, ACTIVE_GAIN),
                    last: slots.matrix(&format!("{name}.last.weight"), w, w, ACTIVE_GAIN),
                    flag: None,
                }
            };
            let edges = if self.shared_edges {
                let one = network("any", kinds);
                (0..kinds).map(|kind| EdgeNetwork { flag: Some(inputs + kind), ..one.clone() }).collect()
            } else {
                self.edges.iter().map(|kind| network(kind, 0)).collect()
            };
            Round { norm, edges, update: slots.perceptron(&format!("{prefix}update"), 2 * w, w, w, 1.0) }
        };
        let rounds = (0..sets).map(round).collect();
        let norm = self.norm(&mut slots, "decoder.");
        let decoder = slots.perceptron("decoder", w, w, 3, 0.0);
        (slots, Layout { encoder, rounds, norm, decoder })
    }

    /// Places of a gain and a shift, where rows are normalised; both start as zero, the gain being what is added to one.
    fn norm(&self, slots: &mut Slots, prefix: &str) -> Option<(usize, usize)> {
        let mut place = |name: &str| slots.matrix(&format!("{prefix}norm.{name}"), 1, self.width, 0.0);
        self.layer_norm.then(|| (place("gain"), place("shift")))
    }

    /// Numbers a node.
    pub fn node_features(&self) -> usize {
        node_features(self.history, self.bodies, self.constants.len())
    }

    /// Number of weights.
    pub fn weight_count(&self) -> usize {
        self.layout().0.count()
    }
}

impl fmt::Display for Architecture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { width, rounds, sharing, aggregation, history, bodies, constants, edges, shared_edges, layer_norm } =
            self;
        write!(
            f,
            "width {width}, {rounds} rounds ({sharing:?}), messages' {aggregation:?}, {history} velocities seen, {bodies} bodies \
             told apart, constants [{}], edge kinds [{}]{}{}",
            constants.join(", "),
            edges.join(", "),
            if *shared_edges { " sharing one network" } else { "" },
            if *layer_norm { ", layer norm" } else { "" }
        )
    }
}
