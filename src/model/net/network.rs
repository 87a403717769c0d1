//! The network's weights, its forward pass and its vector–Jacobian product.
use super::architecture::{Architecture, Layout, Perceptron, Round};
use super::dense::{Finish, dense};
use super::input::{EDGE_FEATURES, Edges, EdgesGrad, Input, InputGrad};
use super::message::{EdgeInput, Weights, message};
use super::record::{Matrix, Record, Wanted, entries};
use dfdx::prelude::{
    Backward, Cpu, CpuError, Gradients, HasShape, NoneTape, OwnedTape, PutTape, Rank0, SumTo, Tape, TensorFromVec,
};

/// A typed message-passing network: nodes and edges in, three numbers a particle out.
#[derive(Clone, Debug)]
pub struct Network {
    architecture: Architecture,
    layout: Layout,
    weights: Vec<Matrix>,
}

/// How many rows, from the first, get an output, and how many get messages.
struct Rows {
    particles: usize,
    receivers: usize,
}

/// The leaves of the tape: what derivatives are asked of.
struct Leaves {
    nodes: Matrix,
    edges: Vec<EdgeInput>,
}

impl Network {
    /// A network whose weights are drawn from the stream of `seed`; its output is zero until the last layer is trained.
    pub fn new(architecture: Architecture, seed: u64) -> Self {
        let layout = architecture.layout();
        let device = Cpu::default();
        let matrix =
            |(values, slot): (Vec<f32>, &super::architecture::Slot)| device.tensor_from_vec(values, slot.shape);
        let weights = layout.start(seed).into_iter().zip(&layout.slots).map(matrix).collect();
        Self { architecture, layout, weights }
    }

    /// What fixes the shapes of the weights.
    pub fn architecture(&self) -> &Architecture {
        &self.architecture
    }

    /// All weights, flat, matrix after matrix in row-major order.
    pub fn weights(&self) -> Vec<f32> {
        self.weights.iter().flat_map(|w| entries(w).iter().copied()).collect()
    }

    /// Whether the output is zero whatever the input: the last layer is still what it starts as.
    pub fn is_silent(&self) -> bool {
        let (weight, bias) = self.layout.decoder.last;
        [weight, bias].iter().all(|&slot| entries(&self.weights[slot]).iter().all(|w| *w == 0.0))
    }

    /// Replaces the weights by `weights`, laid out as [`Network::weights`].
    ///
    /// # Panics
    /// When their number is not [`Architecture::weight_count`].
    pub fn set_weights(&mut self, weights: &[f32]) {
        assert_eq!(weights.len(), self.architecture.weight_count(), "as many weights as the architecture has");
        let mut rest = weights;
        for (matrix, slot) in self.weights.iter_mut().zip(&self.layout.slots) {
            let (own, after) = rest.split_at(slot.len());
            matrix.copy_from(own);
            rest = after;
        }
    }

    /// Each weight matrix with its name and shape, in the order of the flat layout.
    pub(super) fn named(&self) -> impl Iterator<Item = (&str, (usize, usize), &[f32])> {
        self.layout.slots.iter().zip(&self.weights).map(|(slot, w)| (slot.name.as_str(), slot.shape, entries(w)))
    }

    /// The output, (N, 3) row-major.
    pub fn forward(&self, input: Input) -> Vec<f32> {
        let mut record = Record::<NoneTape>::new(Wanted::Inputs);
        let (rows, leaves) = self.leaves(&record, input);
        entries(&self.run(&mut record, &rows, &leaves)).to_vec()
    }

    /// The output and `∂J/∂input` from `∂J/∂output`, (N, 3) both; adds `∂J/∂weights` to `weights` unless that slice is empty.
    pub fn pull(&self, input: Input, at_output: &[f32], weights: &mut [f32]) -> (Vec<f32>, InputGrad) {
        if input.particles == 0 {
            return (Vec::new(), InputGrad::zero(&input));
        }
        let wanted = if weights.is_empty() { Wanted::Inputs } else { Wanted::InputsAndWeights };
        let mut record = Record::<OwnedTape<f32, Cpu>>::new(wanted);
        let (rows, leaves) = self.leaves(&record, input);
        let output = self.run(&mut record, &rows, &leaves);
        let cotangent = record.matrix(at_output.to_vec(), 3);
        let rows = entries(&output).to_vec();
        let mut grads = (output.put_tape(record.tape) * cotangent).sum::<Rank0, _>().backward();
        let grad = self.collect(&mut grads, &leaves, weights);
        (rows, grad.expect("gradients of tensors that were just used fit in memory"))
    }

    fn collect(
        &self,
        grads: &mut Gradients<f32, Cpu>,
        leaves: &Leaves,
        weights: &mut [f32],
    ) -> Result<InputGrad, CpuError> {
        if !weights.is_empty() {
            let mut rest = weights;
            for matrix in &self.weights {
                let own = grads.get_or_alloc_mut(matrix)?;
                let (head, tail) = rest.split_at_mut(own.len());
                head.iter_mut().zip(own.iter()).for_each(|(w, g)| *w += g);
                rest = tail;
            }
        }
        let mut take = |leaf: &Matrix| Ok(std::mem::take(&mut **grads.get_or_alloc_mut(leaf)?));
        let nodes = take(&leaves.nodes)?;
        let edge = |e: &EdgeInput| Ok(EdgesGrad { features: take(&e.features)?, window: take(&e.window)? });
        Ok(InputGrad { nodes, edges: leaves.edges.iter().map(edge).collect::<Result<_, _>>()? })
    }

    fn run<T: Tape<f32, Cpu>>(&self, record: &mut Record<T>, rows: &Rows, leaves: &Leaves) -> Matrix {
        let count = leaves.nodes.shape().0;
        let encoder = &self.layout.encoder;
        let inner = self.layer(record, count, &leaves.nodes, encoder);
        let mut nodes = self.last(record, count, &inner, encoder, Finish::Linear);
        let shared = |e: &EdgeInput| EdgeInput {
            window: self.architecture.aggregation.shares(record, &e.links, &e.window),
            ..e.clone()
        };
        let edges: Vec<_> = leaves.edges.iter().map(shared).collect();
        for round in self.layout.rounds.iter().cycle().take(self.architecture.rounds) {
            nodes = self.round(record, rows.receivers, &nodes, &edges, round);
        }
        let decoder = &self.layout.decoder;
        let inner = self.layer(record, rows.particles, &nodes, decoder);
        self.last(record, rows.particles, &inner, decoder, Finish::Linear)
    }

    fn round<T: Tape<f32, Cpu>>(
        &self,
        record: &mut Record<T>,
        receivers: usize,
        nodes: &Matrix,
        edges: &[EdgeInput],
        round: &Round,
    ) -> Matrix {
        let pair = |(weight, bias): (usize, usize)| (self.weights[weight].clone(), self.weights[bias].clone());
        let mut sums = Vec::new();
        for (network, edges) in round.edges.iter().zip(edges) {
            if !edges.links.is_empty() {
                let weights = Weights { first: pair(network.first), hidden: pair(network.hidden) };
                let sum = message(record, receivers, nodes, edges, &weights, self.architecture.aggregation);
                sums.push((sum, &self.weights[network.last]));
            }
        }
        let width = self.architecture.width;
        let (weight, bias) = round.update.first;
        let (weight, bias) = (&self.weights[weight], Some(&self.weights[bias]));
        // Without edges the sum of messages is exactly zero and its product is left out.
        let inner = if sums.is_empty() {
            dense(record, receivers, &[(nodes, weight, 0)], bias, Finish::Squareplus)
        } else {
            let terms: Vec<_> = sums.iter().map(|(sum, last)| (sum, *last, 0)).collect();
            let aggregate = dense(record, receivers, &terms, None, Finish::Linear);
            let terms = [(nodes, weight, 0), (&aggregate, weight, width)];
            dense(record, receivers, &terms, bias, Finish::Squareplus)
        };
        self.last(record, receivers, &inner, &round.update, Finish::Onto(nodes))
    }

    fn layer<T: Tape<f32, Cpu>>(&self, record: &mut Record<T>, rows: usize, x: &Matrix, p: &Perceptron) -> Matrix {
        let (weight, bias) = p.first;
        dense(record, rows, &[(x, &self.weights[weight], 0)], Some(&self.weights[bias]), Finish::Squareplus)
    }

    fn last<T: Tape<f32, Cpu>>(
        &self,
        record: &mut Record<T>,
        rows: usize,
        x: &Matrix,
        p: &Perceptron,
        finish: Finish<'_>,
    ) -> Matrix {
        let (weight, bias) = p.last;
        dense(record, rows, &[(x, &self.weights[weight], 0)], Some(&self.weights[bias]), finish)
    }

    fn leaves<T: Tape<f32, Cpu>>(&self, record: &Record<T>, input: Input) -> (Rows, Leaves) {
        let edge = |e: Edges| EdgeInput {
            links: e.links,
            features: record.matrix(e.features, EDGE_FEATURES),
            window: record.matrix(e.window, 1),
        };
        let edges = input.edges.into_iter().map(edge).collect();
        let rows = Rows { particles: input.particles, receivers: input.receivers };
        (rows, Leaves { nodes: record.matrix(input.nodes, self.architecture.node_features()), edges })
    }
}
