//! The table of edge kinds: who sends to a particle, and what the edge means.
use super::{CellList, EdgeSet, Nodes};

/// What an edge means. A new kind is one implementation and one row of [`EDGE_KINDS`].
pub trait EdgeKind: Sync {
    /// Its name in configs, weights and tables.
    fn name(&self) -> &'static str;
    /// Its edges into every particle within `radius` \[m\]; `cells` indexes `nodes.positions`.
    fn connect(&self, nodes: &Nodes, cells: &CellList, radius: f64) -> EdgeSet;
}

/// Every edge kind, in the order of [`super::Graph::edges`].
pub static EDGE_KINDS: &[&dyn EdgeKind] = &[&ParticleToParticle, &ToolToParticle, &FloorToParticle];

struct ParticleToParticle;
struct ToolToParticle;
struct FloorToParticle;

impl EdgeKind for ParticleToParticle {
    fn name(&self) -> &'static str {
        "particle"
    }
    fn connect(&self, nodes: &Nodes, cells: &CellList, radius: f64) -> EdgeSet {
        cells.neighbours(nodes, radius, |receiver, sender| sender < nodes.particles && sender != receiver)
    }
}

impl EdgeKind for ToolToParticle {
    fn name(&self) -> &'static str {
        "tool"
    }
    fn connect(&self, nodes: &Nodes, cells: &CellList, radius: f64) -> EdgeSet {
        cells.neighbours(nodes, radius, |_, sender| sender >= nodes.particles && sender < nodes.floor())
    }
}

impl EdgeKind for FloorToParticle {
    fn name(&self) -> &'static str {
        "floor"
    }
    fn connect(&self, nodes: &Nodes, _: &CellList, radius: f64) -> EdgeSet {
        let mut set = EdgeSet { offsets: vec![0], senders: Vec::new() };
        for position in &nodes.positions[..nodes.particles] {
            if position.z < radius {
                set.senders.push(nodes.floor() as u32);
            }
            set.offsets.push(set.senders.len() as u32);
        }
        set
    }
}
