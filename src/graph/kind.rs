//! The table of edge kinds: who sends to a particle, and what the edge means.
use super::{EdgeSet, Nodes};
use anyhow::Context;

/// What an edge means. A new kind is one implementation and one row of [`EDGE_KINDS`].
pub trait EdgeKind: Sync {
    /// Its name in configs, weights and tables.
    fn name(&self) -> &'static str;
    /// Its edges into every particle or root; where it joins what is near, some of `near`, which holds the edges from all that is
    /// within `radius` \[m\].
    fn connect(&self, nodes: &Nodes, near: &EdgeSet, radius: f64) -> EdgeSet;
    /// How its messages fade with distance.
    fn window(&self) -> Window {
        Window::Fading
    }
    /// The kind of graph whose skeleton it is drawn along, if it needs one.
    fn needs(&self) -> Option<&'static str> {
        None
    }
}

/// How messages fade with distance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Window {
    /// To zero at the graph's radius.
    Fading,
    /// Not at all: whom the edge joins does not depend on where they are.
    Open,
}

/// Every edge kind, in the order of [`super::Graph::edges`].
pub static EDGE_KINDS: &[&dyn EdgeKind] =
    &[&ParticleToParticle, &ToolToParticle, &FloorToParticle, &LeafToRoot, &RootToRoot, &RootToLeaf, &Bond];

/// The kinds that join what is near, and need no skeleton.
pub fn near_kinds() -> impl Iterator<Item = &'static dyn EdgeKind> {
    EDGE_KINDS.iter().copied().filter(|kind| kind.window() == Window::Fading)
}

/// The places in [`EDGE_KINDS`] of the kinds that `key` of a config names.
///
/// # Errors
/// When a name is no kind's.
pub(crate) fn kinds_named(key: &str, names: &[String]) -> anyhow::Result<Vec<usize>> {
    let known = || EDGE_KINDS.iter().map(|kind| kind.name()).collect::<Vec<_>>().join(", ");
    let place = |name: &String| {
        let found = EDGE_KINDS.iter().position(|kind| kind.name() == name);
        found.with_context(|| format!("{key} names {name:?}; known edge kinds are {}", known()))
    };
    names.iter().map(place).collect()
}

struct ParticleToParticle;
struct ToolToParticle;
struct FloorToParticle;
struct LeafToRoot;
struct RootToRoot;
struct RootToLeaf;
struct Bond;

impl EdgeKind for ParticleToParticle {
    fn name(&self) -> &'static str {
        "particle"
    }
    fn connect(&self, nodes: &Nodes, near: &EdgeSet, _: f64) -> EdgeSet {
        near.only(|receiver, sender| sender < nodes.particles && sender != receiver)
    }
}

impl EdgeKind for ToolToParticle {
    fn name(&self) -> &'static str {
        "tool"
    }
    fn connect(&self, nodes: &Nodes, near: &EdgeSet, _: f64) -> EdgeSet {
        let samples = nodes.tool();
        near.only(|_, sender| samples.contains(&sender))
    }
}

/// From the floor, and from walls where there are any.
impl EdgeKind for FloorToParticle {
    fn name(&self) -> &'static str {
        "floor"
    }
    fn connect(&self, nodes: &Nodes, _: &EdgeSet, radius: f64) -> EdgeSet {
        let mut set = EdgeSet { offsets: vec![0], senders: Vec::new() };
        for position in &nodes.positions[..nodes.particles] {
            let near = nodes.planes().zip(&nodes.planes).filter(|(_, plane)| plane.distance(*position) < radius);
            set.senders.extend(near.map(|(row, _)| row as u32));
            set.offsets.push(set.senders.len() as u32);
        }
        set
    }
}

/// Sent by what is right under a root: particles, or roots of the level below (Li et al. 2019, DPI-Net, §3.2).
impl EdgeKind for LeafToRoot {
    fn name(&self) -> &'static str {
        "leaf_root"
    }
    fn connect(&self, nodes: &Nodes, _: &EdgeSet, _: f64) -> EdgeSet {
        let mut rows = vec![Vec::new(); nodes.receivers()];
        nodes.roots().children().for_each(|(root, children)| rows[root] = children.to_vec());
        EdgeSet::from_rows(rows)
    }
    fn window(&self) -> Window {
        Window::Open
    }
    fn needs(&self) -> Option<&'static str> {
        Some("hierarchy")
    }
}

/// Between all roots of a body on one level.
impl EdgeKind for RootToRoot {
    fn name(&self) -> &'static str {
        "root_root"
    }
    fn connect(&self, nodes: &Nodes, _: &EdgeSet, _: f64) -> EdgeSet {
        let mut rows = vec![Vec::new(); nodes.receivers()];
        for level in nodes.roots().levels() {
            for root in level.clone() {
                rows[root] = level.clone().filter(|&other| other != root).map(|other| other as u32).collect();
            }
        }
        EdgeSet::from_rows(rows)
    }
    fn window(&self) -> Window {
        Window::Open
    }
    fn needs(&self) -> Option<&'static str> {
        Some("hierarchy")
    }
}

impl EdgeKind for RootToLeaf {
    fn name(&self) -> &'static str {
        "root_leaf"
    }
    fn connect(&self, nodes: &Nodes, _: &EdgeSet, _: f64) -> EdgeSet {
        let mut rows = vec![Vec::new(); nodes.receivers()];
        for (root, children) in nodes.roots().children() {
            children.iter().for_each(|&child| rows[child as usize].push(root as u32));
        }
        EdgeSet::from_rows(rows)
    }
    fn window(&self) -> Window {
        Window::Open
    }
    fn needs(&self) -> Option<&'static str> {
        Some("hierarchy")
    }
}

/// Between particles that were near at the start, however far apart they are now.
impl EdgeKind for Bond {
    fn name(&self) -> &'static str {
        "bond"
    }
    fn connect(&self, nodes: &Nodes, _: &EdgeSet, _: f64) -> EdgeSet {
        nodes.skeleton.bonds.clone()
    }
    fn window(&self) -> Window {
        Window::Open
    }
    fn needs(&self) -> Option<&'static str> {
        Some("fixed")
    }
}
