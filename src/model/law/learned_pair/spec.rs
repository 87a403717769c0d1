//! The config of a learned pair law.
use super::{INPUTS, LearnedPair, OUTPUTS};
use crate::graph::{EDGE_KINDS, kinds_named};
use crate::model::law::compliant::positive;
use crate::model::net::Stack;
use anyhow::ensure;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Places in [`EDGE_KINDS`] before this are of kinds that need no roots: particle, tool and floor.
const WITHOUT_ROOTS: usize = 3;

/// Config of [`LearnedPair`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LearnedPairSpec {
    /// Width of both hidden layers.
    #[schemars(range(min = 1, max = 256))]
    pub width: usize,
    /// What acts on a particle: `particle`, `tool`, `floor`, each with a network of its own.
    pub edges: Vec<String>,
    /// Distance of two centres beyond which there is nothing \[m\].
    #[schemars(range(min = 1e-6))]
    pub radius: f64,
    /// Distance from the tool's surface and from the table beyond which there is nothing \[m\].
    #[schemars(range(min = 1e-6))]
    pub skin: f64,
    /// Acceleration that an output of one stands for \[m/s²\].
    #[schemars(range(min = 1e-9))]
    pub strength: f64,
    /// Relative speed that counts as one \[m/s\].
    #[schemars(range(min = 1e-9))]
    pub speed: f64,
    /// Seed of the untrained weights.
    pub seed: u64,
    /// File of trained weights (safetensors).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub weights: Option<PathBuf>,
}

impl LearnedPairSpec {
    /// The law, with the weights of the file or untrained.
    ///
    /// # Errors
    /// A sentence naming the impossible key, or what is wrong with the file of weights.
    pub fn build(self) -> anyhow::Result<LearnedPair> {
        ensure!((1..=256).contains(&self.width), "width must be between 1 and 256, got {}", self.width);
        let lengths =
            [("radius", self.radius), ("skin", self.skin), ("strength", self.strength), ("speed", self.speed)];
        lengths.into_iter().try_for_each(|(key, value)| positive("learned_pair", key, value))?;
        let kinds = kinds_named("edges", &self.edges)?;
        for (i, kind) in kinds.iter().enumerate() {
            ensure!(!kinds[..i].contains(kind), "edges names {:?} twice", self.edges[i]);
            ensure!(
                *kind < WITHOUT_ROOTS,
                "edges names {:?}; a learned pair law knows {}",
                self.edges[i],
                EDGE_KINDS[..WITHOUT_ROOTS].iter().map(|kind| kind.name()).collect::<Vec<_>>().join(", ")
            );
        }
        let mut stack = Stack::new(&self.edges, [INPUTS, self.width, OUTPUTS], self.seed);
        if let Some(path) = &self.weights {
            stack.load(path)?;
        }
        Ok(LearnedPair { kinds, stack, spec: self })
    }
}
