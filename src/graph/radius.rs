//! Edges between nodes closer than a radius.
use super::{EDGE_KINDS, EdgeSet, Graph, GraphPolicy, Nodes, Window, kinds_named};
use anyhow::ensure;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Config of [`Radius`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RadiusSpec {
    /// Radius of the neighbourhood \[m\].
    #[schemars(range(min = 1e-6))]
    pub radius: f64,
    /// Names of the edge kinds to draw.
    pub edges: Vec<String>,
    /// Most edges of a kind into a particle, from the nearest; all within the radius where it is absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1))]
    pub degree: Option<usize>,
}

impl RadiusSpec {
    pub(crate) fn build(self) -> anyhow::Result<Radius> {
        Radius::new(self.radius, &self.edges, self.degree, "radius")
    }
}

/// Joins every particle to the nodes within a radius.
#[derive(Clone, Debug)]
pub struct Radius {
    radius: f64,
    kinds: Vec<usize>,
    degree: Option<usize>,
}

impl Radius {
    /// Draws the named kinds of edges within `radius` \[m\], of those that join what is near the nearest `degree`, in a graph of the
    /// kind `policy`.
    ///
    /// # Errors
    /// When the radius is no length, the degree is zero, a name is no kind's, or a kind of edges needs another kind of graph.
    pub(super) fn new(radius: f64, edges: &[String], degree: Option<usize>, policy: &str) -> anyhow::Result<Self> {
        ensure!(radius > 0.0 && radius.is_finite(), "graph.radius must be a positive length, got {radius}");
        ensure!(degree != Some(0), "graph.degree is 0: leave out the kinds that nothing is to be heard of by");
        let kinds = kinds_named("graph.edges", edges)?;
        for kind in kinds.iter().map(|&kind| EDGE_KINDS[kind]) {
            let needs = kind.needs().unwrap_or(policy);
            ensure!(needs == policy, "graph.edges names {:?}, which needs graph.kind = {needs:?}", kind.name());
        }
        Ok(Self { radius, kinds, degree })
    }
}

impl GraphPolicy for Radius {
    fn connect(&self, nodes: Nodes) -> Graph {
        let near = nodes.near(self.radius);
        let mut edges = vec![EdgeSet { offsets: vec![0; nodes.particles + 1], senders: Vec::new() }; EDGE_KINDS.len()];
        for &kind in &self.kinds {
            let all = EDGE_KINDS[kind].connect(&nodes, &near, self.radius);
            edges[kind] = match self.degree {
                Some(most) if EDGE_KINDS[kind].window() == Window::Fading => all.nearest(&nodes, most),
                _ => all,
            };
        }
        Graph { nodes, edges }
    }

    fn reach(&self) -> f64 {
        self.radius
    }
}
