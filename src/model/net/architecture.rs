//! The shapes of a network's weights, their names and how they start.
use super::Aggregation;
use super::input::{EDGE_FEATURES, NODE_FEATURES};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

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

/// One weight matrix (a bias is a matrix of one row).
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Slot {
    pub(super) name: String,
    pub(super) shape: (usize, usize),
    deviation: f64,
}

/// Places in the list of slots of a two-layer perceptron.
#[derive(Clone, Debug)]
pub(super) struct Perceptron {
    pub(super) first: (usize, usize),
    pub(super) last: (usize, usize),
}

/// Places of an edge network's three layers; the last has no bias, a constant hidden unit stands in for it.
#[derive(Clone, Debug)]
pub(super) struct EdgeNetwork {
    pub(super) first: (usize, usize),
    pub(super) hidden: (usize, usize),
    pub(super) last: usize,
}

/// Places of one round's weights.
#[derive(Clone, Debug)]
pub(super) struct Round {
    pub(super) edges: Vec<EdgeNetwork>,
    pub(super) update: Perceptron,
}

/// Every weight matrix in the order of the flat layout, and where each block finds its own.
#[derive(Clone, Debug)]
pub(super) struct Layout {
    pub(super) slots: Vec<Slot>,
    pub(super) encoder: Perceptron,
    /// One entry a set of weights: a single one when rounds share.
    pub(super) rounds: Vec<Round>,
    pub(super) decoder: Perceptron,
}

impl Architecture {
    pub(super) fn layout(&self) -> Layout {
        let w = self.width;
        let mut slots = Slots(Vec::new());
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
            let edges = self.edges.iter().map(|kind| {
                let name = format!("{prefix}edge.{kind}");
                EdgeNetwork {
                    first: slots.layer(&format!("{name}.first"), 2 * w + EDGE_FEATURES, w, 1.0),
                    hidden: slots.layer(&format!("{name}.hidden"), w, w, ACTIVE_GAIN),
                    last: slots.matrix(&format!("{name}.last.weight"), w, w, ACTIVE_GAIN),
                }
            });
            let edges = edges.collect();
            Round { edges, update: slots.perceptron(&format!("{prefix}update"), 2 * w, w, w, 1.0) }
        };
        let rounds = (0..sets).map(round).collect();
        let decoder = slots.perceptron("decoder", w, w, 3, 0.0);
        Layout { slots: slots.0, encoder, rounds, decoder }
    }

    /// Numbers a node.
    pub fn node_features(&self) -> usize {
        node_features(self.history, self.bodies, self.constants.len())
    }

    /// Number of weights.
    pub fn weight_count(&self) -> usize {
        self.layout().slots.iter().map(Slot::len).sum()
    }
}

/// `1/σ` of a squareplus of a standard normal variable: restores unit variance behind the activation.
const ACTIVE_GAIN: f64 = 1.852_76;

struct Slots(Vec<Slot>);

impl Slots {
    /// `deviation = gain/√fan_in` keeps the variance of unit inputs (He et al. 2015, eq. 10, for our activation).
    fn matrix(&mut self, name: &str, rows: usize, columns: usize, gain: f64) -> usize {
        let deviation = gain / (rows as f64).sqrt();
        self.0.push(Slot { name: name.to_owned(), shape: (rows, columns), deviation });
        self.0.len() - 1
    }

    fn layer(&mut self, name: &str, inputs: usize, outputs: usize, gain: f64) -> (usize, usize) {
        let weight = self.matrix(&format!("{name}.weight"), inputs, outputs, gain);
        (weight, self.matrix(&format!("{name}.bias"), 1, outputs, 0.0))
    }

    fn perceptron(&mut self, name: &str, inputs: usize, width: usize, outputs: usize, last: f64) -> Perceptron {
        Perceptron {
            first: self.layer(&format!("{name}.first"), inputs, width, 1.0),
            last: self.layer(&format!("{name}.last"), width, outputs, last * ACTIVE_GAIN),
        }
    }
}

impl Slot {
    pub(super) fn len(&self) -> usize {
        self.shape.0 * self.shape.1
    }
}

impl Layout {
    /// Normal weights from one ChaCha8 stream in the order of the layout; biases and the decoder's last layer are zero.
    pub(super) fn start(&self, seed: u64) -> Vec<Vec<f32>> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut draw = |deviation: f64| -> f32 {
            let normal: f64 = StandardNormal.sample(&mut rng);
            (deviation * normal) as f32
        };
        let fill = |slot: &Slot| match slot.deviation {
            0.0 => vec![0.0; slot.len()],
            deviation => (0..slot.len()).map(|_| draw(deviation)).collect(),
        };
        self.slots.iter().map(fill).collect()
    }
}
