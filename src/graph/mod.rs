//! Graphs over particles: typed edges, and the policies that draw them.
//!
//! Nodes are numbered `[particles | roots | tool surface samples | walls | floor]`; edges of one kind form one [`EdgeSet`], sorted by
//! receiver and then by the sender's place, so that every neighbour sum runs in one fixed order.
use crate::state::Particles;

mod cell_list;
mod fixed;
mod hierarchy;
mod kind;
mod node;
mod radius;
mod roots;

pub use cell_list::CellList;
pub use fixed::{Fixed, FixedSpec};
pub use hierarchy::{Hierarchy, HierarchySpec};
pub(crate) use kind::kinds_named;
pub use kind::{EDGE_KINDS, EdgeKind, Window, near_kinds};
pub use node::Nodes;
pub use radius::Radius;
pub use roots::Roots;

/// The directed edges of one kind, in compressed rows by receiver.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EdgeSet {
    /// `offsets[i]..offsets[i + 1]` are the edges that row i receives; as many entries as there are receivers, and one.
    pub offsets: Vec<u32>,
    /// Sender node of each edge.
    pub senders: Vec<u32>,
}

impl EdgeSet {
    /// From the senders to every receiver.
    fn from_rows(rows: Vec<Vec<u32>>) -> Self {
        let mut set = Self { offsets: vec![0], senders: Vec::new() };
        for senders in rows {
            set.senders.extend(senders);
            set.offsets.push(set.senders.len() as u32);
        }
        set
    }

    /// Of every receiver's edges those from the `most` nearest senders, the earlier of two that are equally far.
    fn nearest(&self, nodes: &Nodes, most: usize) -> Self {
        let row = |(i, ends): (usize, &[u32])| {
            let mut senders = self.senders[ends[0] as usize..ends[1] as usize].to_vec();
            let far = |j: &u32| nodes.offset(i, *j as usize).length_squared();
            senders.sort_by(|a, b| far(a).total_cmp(&far(b)));
            senders.truncate(most);
            senders.sort_unstable();
            senders
        };
        Self::from_rows(self.offsets.windows(2).enumerate().map(row).collect())
    }

    /// The edges that `keep(receiver, sender)` says.
    pub fn only(&self, keep: impl Fn(usize, usize) -> bool) -> Self {
        let mut set = Self { offsets: vec![0], senders: Vec::with_capacity(self.len()) };
        for (i, row) in self.offsets.windows(2).enumerate() {
            let row = &self.senders[row[0] as usize..row[1] as usize];
            set.senders.extend(row.iter().copied().filter(|&j| keep(i, j as usize)));
            set.offsets.push(set.senders.len() as u32);
        }
        set
    }

    /// Number of edges.
    pub fn len(&self) -> usize {
        self.senders.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.senders.is_empty()
    }

    /// Every edge as (receiver, sender), in order.
    pub fn pairs(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let rows = self.offsets.windows(2).enumerate();
        rows.flat_map(|(i, w)| self.senders[w[0] as usize..w[1] as usize].iter().map(move |&j| (i, j as usize)))
    }
}

/// Nodes and, for every kind of [`EDGE_KINDS`] by its place there, its edges.
#[derive(Clone, Debug, Default)]
pub struct Graph {
    /// Particles, roots, tool surface samples, walls and the floor.
    pub nodes: Nodes,
    /// One set per row of [`EDGE_KINDS`]; empty where the policy does not draw that kind.
    pub edges: Vec<EdgeSet>,
}

/// What is drawn at the start of a rollout and kept while the particles move.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Skeleton {
    /// Roots over the particles.
    pub roots: Roots,
    /// Particles that stay joined, as edges into each; no rows where the policy draws none.
    pub bonds: EdgeSet,
}

/// Draws edges. What counts as a neighbour is a decision, so it has a name and a config.
pub trait GraphPolicy: Send + Sync {
    /// What a rollout that starts from these particles of numbered bodies keeps of its first graph.
    fn skeleton(&self, _: &Particles, _: &[u32]) -> Skeleton {
        Skeleton::default()
    }
    /// The edges between these nodes.
    fn connect(&self, nodes: Nodes) -> Graph;
    /// Radius of the neighbourhood \[m\]: a message fades to zero there.
    fn reach(&self) -> f64;
}

family! {
    /// Every graph policy that a config can name.
    GraphSpec builds Box<dyn GraphPolicy> {
        Radius(radius::RadiusSpec),
        Hierarchy(hierarchy::HierarchySpec),
        Fixed(fixed::FixedSpec),
    }
}
