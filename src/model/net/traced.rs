//! What a network computed on the way forward, kept for the way back.
use super::architecture::Architecture;
use super::input::{EdgesGrad, InputGrad};
use super::message::EdgeInput;
use super::parameters::Parameters;
use super::record::{Matrix, Record, Wanted, entries};
use dfdx::prelude::{Cpu, CpuError, Gradients, HasShape, OwnedTape};

/// The output of a [`super::Network`], and all that its derivatives need.
pub struct Traced<'a> {
    pub(super) architecture: &'a Architecture,
    pub(super) weights: &'a Parameters,
    pub(super) record: Record<OwnedTape<f32, Cpu>>,
    pub(super) leaves: Leaves,
    pub(super) output: Matrix,
}

/// The leaves of the tape: what derivatives are asked of.
pub(super) struct Leaves {
    pub(super) nodes: Matrix,
    pub(super) edges: Vec<EdgeInput>,
}

impl Traced<'_> {
    /// (N, 3) row-major.
    pub fn output(&self) -> &[f32] {
        entries(&self.output)
    }

    /// Memory that it holds, but for what is small: of every edge two hidden layers a round, of every node four layers a round.
    pub fn bytes(&self) -> usize {
        let Architecture { width, rounds, .. } = self.architecture;
        let edges: usize = self.leaves.edges.iter().map(|edges| edges.links.len()).sum();
        size_of::<f32>() * width * rounds * (2 * edges + 4 * self.leaves.nodes.shape().0)
    }

    /// `∂J/∂input` from `∂J/∂output`, (N, 3); adds `∂J/∂weights` to `weights` unless that slice is empty.
    ///
    /// # Panics
    /// When weights' derivatives are asked for that were not wanted.
    pub fn pull(self, at_output: &[f32], weights: &mut [f32]) -> InputGrad {
        let Self { record, leaves, output, .. } = self;
        let wanted = weights.is_empty() || record.wanted == Wanted::InputsAndWeights;
        assert!(wanted, "weights' derivatives were not wanted");
        if at_output.is_empty() {
            return leaves.zero();
        }
        let mut grads = record.backward(output, at_output);
        let grad = self.weights.collect(&mut grads, weights).and_then(|()| leaves.collect(&mut grads));
        grad.expect("gradients of tensors that were just used fit in memory")
    }
}

impl Leaves {
    fn zero(&self) -> InputGrad {
        let zero = |x: &Matrix| vec![0.0; entries(x).len()];
        let edge = |e: &EdgeInput| EdgesGrad { features: zero(&e.features), window: zero(&e.window) };
        InputGrad { nodes: zero(&self.nodes), edges: self.edges.iter().map(edge).collect() }
    }

    fn collect(&self, grads: &mut Gradients<f32, Cpu>) -> Result<InputGrad, CpuError> {
        let mut take = |leaf: &Matrix| Ok(std::mem::take(&mut **grads.get_or_alloc_mut(leaf)?));
        let nodes = take(&self.nodes)?;
        let edge = |e: &EdgeInput| Ok(EdgesGrad { features: take(&e.features)?, window: take(&e.window)? });
        Ok(InputGrad { nodes, edges: self.edges.iter().map(edge).collect::<Result<_, _>>()? })
    }
}
