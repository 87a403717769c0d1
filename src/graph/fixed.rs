//! A graph whose particles stay joined to those that were near when a rollout began.
use super::{Graph, GraphPolicy, Nodes, Radius, Skeleton};
use crate::state::Particles;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Config of [`Fixed`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FixedSpec {
    /// Radius within which particles are bonded at the start, and of the neighbourhood of the kinds that join what is near \[m\].
    #[schemars(range(min = 1e-6))]
    pub radius: f64,
    /// Names of the edge kinds to draw; `bond` is drawn once, the others in every step.
    pub edges: Vec<String>,
    /// Most edges of a kind into a particle, from the nearest; all within the radius where it is absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1))]
    pub degree: Option<usize>,
}

impl FixedSpec {
    pub(crate) fn build(self) -> anyhow::Result<Fixed> {
        Ok(Fixed { near: Radius::new(self.radius, &self.edges, self.degree, "fixed")?, degree: self.degree })
    }
}

/// Bonds drawn once between particles of a body, everything else within a radius in every step: for what deforms and does not flow.
#[derive(Clone, Debug)]
pub struct Fixed {
    near: Radius,
    degree: Option<usize>,
}

impl GraphPolicy for Fixed {
    fn skeleton(&self, particles: &Particles, body: &[u32]) -> Skeleton {
        let positions = particles.positions.clone();
        let nodes = Nodes { particles: positions.len(), positions, ..Nodes::default() };
        let all = nodes.near(self.reach()).only(|i, j| i != j && body[i] == body[j]);
        let bonds = self.degree.map(|most| all.nearest(&nodes, most)).unwrap_or(all);
        Skeleton { bonds, ..Skeleton::default() }
    }

    fn connect(&self, nodes: Nodes) -> Graph {
        self.near.connect(nodes)
    }

    fn reach(&self) -> f64 {
        self.near.reach()
    }
}
