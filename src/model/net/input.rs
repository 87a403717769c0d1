//! What the network reads, and the derivatives with respect to it.
use std::sync::Arc;

/// Numbers a node that every network reads: velocity (3), role (3), height (1), normal (3); where bodies are told apart, one a body
/// follows, where the past is seen, three a velocity, and one a constant of the scene.
pub(super) const NODE_FEATURES: usize = 10;
/// Numbers an edge: offset (3), distance (1), sender's normal (3), relative displacement (3).
pub(super) const EDGE_FEATURES: usize = 10;

/// Nodes and edges as numbers.
#[derive(Clone, Debug, Default)]
pub struct Input {
    /// Number of particles N, the first rows: those that get an output.
    pub particles: usize,
    /// Number of receiving nodes, particles and roots; ≥ N.
    pub receivers: usize,
    /// Node features, M ≥ receivers rows of as many numbers as [`super::Architecture::node_features`] says.
    pub nodes: Vec<f32>,
    /// One entry for every edge kind of the architecture.
    pub edges: Vec<Edges>,
}

/// The edges of one kind as numbers.
#[derive(Clone, Debug, Default)]
pub struct Edges {
    /// Who is joined to whom.
    pub links: Arc<Links>,
    /// Edge features, (E, 10) row-major.
    pub features: Vec<f32>,
    /// Window w(r) of each edge, E numbers.
    pub window: Vec<f32>,
}

/// Receiver and sender row of each edge, sorted by receiver.
#[derive(Clone, Debug, Default)]
pub struct Links {
    /// Receiving node of each edge, E numbers.
    pub receivers: Vec<u32>,
    /// Sending node of each edge, E numbers.
    pub senders: Vec<u32>,
}

/// `∂J/∂input`.
#[derive(Clone, Debug, Default)]
pub struct InputGrad {
    /// `∂J/∂(node features)`.
    pub nodes: Vec<f32>,
    /// One entry for every edge kind.
    pub edges: Vec<EdgesGrad>,
}

/// `∂J/∂edges`.
#[derive(Clone, Debug, Default)]
pub struct EdgesGrad {
    /// `∂J/∂features`, (E, 10).
    pub features: Vec<f32>,
    /// `∂J/∂window`, E numbers.
    pub window: Vec<f32>,
}

impl Links {
    /// Number of edges E.
    pub fn len(&self) -> usize {
        self.senders.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.senders.is_empty()
    }
}
