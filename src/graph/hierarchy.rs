//! A graph with roots over its particles.
use super::{Graph, GraphPolicy, Nodes, Radius, Roots, Skeleton};
use crate::state::Particles;
use anyhow::ensure;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// Config of [`Hierarchy`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HierarchySpec {
    /// Radius of the neighbourhood of particles \[m\].
    #[schemars(range(min = 1e-6))]
    pub radius: f64,
    /// Names of the edge kinds to draw.
    pub edges: Vec<String>,
    /// Most edges into a particle of a kind that joins what is near, from the nearest; all within the radius where it is absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1))]
    pub degree: Option<usize>,
    /// Number of roots of each level over a body, the lowest first; an empty list is a flat graph.
    pub roots: Vec<usize>,
    /// Numbers of the bodies that have roots; all where it is absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bodies: Option<Vec<u32>>,
}

impl HierarchySpec {
    pub(crate) fn build(self) -> anyhow::Result<Hierarchy> {
        let mut above = usize::MAX;
        for &count in &self.roots {
            ensure!(
                (1..=4096).contains(&count) && count < above,
                "graph.roots = {:?} must fall from level to level and lie in [1, 4096]",
                self.roots
            );
            above = count;
        }
        Ok(Hierarchy {
            near: Radius::new(self.radius, &self.edges, self.degree, "hierarchy")?,
            counts: self.roots,
            bodies: self.bodies,
        })
    }
}

/// Particles joined within a radius, and roots over them.
#[derive(Clone, Debug)]
pub struct Hierarchy {
    near: Radius,
    counts: Vec<usize>,
    bodies: Option<Vec<u32>>,
}

impl GraphPolicy for Hierarchy {
    fn skeleton(&self, particles: &Particles, body: &[u32]) -> Skeleton {
        let rooted = |number: &u32| self.bodies.as_ref().is_none_or(|bodies| bodies.contains(number));
        let numbers: BTreeSet<u32> = body.iter().copied().filter(rooted).collect();
        let rows = |number: u32| (0..body.len()).filter(|&i| body[i] == number).map(|i| i as u32).collect();
        let each: Vec<Vec<u32>> = numbers.into_iter().map(rows).collect();
        Skeleton { roots: Roots::over(&particles.positions, &each, &self.counts), ..Skeleton::default() }
    }

    fn connect(&self, nodes: Nodes) -> Graph {
        self.near.connect(nodes)
    }

    fn reach(&self) -> f64 {
        self.near.reach()
    }
}
