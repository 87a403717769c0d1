//! The network's weights, its forward pass and its vector–Jacobian product.
use super::architecture::{Architecture, Layout, Round};
use super::dense::{Finish, dense};
use super::input::{EDGE_FEATURES, Edges, EdgesGrad, Input, InputGrad};
use super::message::{EdgeInput, Weights, message};
use super::parameters::{Parameters, Perceptron};
use super::record::{Matrix, Record, Wanted, entries};
use super::weights::{load, save};
use dfdx::prelude::{Cpu, CpuError, Gradients, HasShape, NoneTape, OwnedTape, Tape};
use std::path::Path;

/// A typed message-passing network: nodes and edges in, three numbers a particle out.
#[derive(Clone, Debug)]
pub struct Network {
    architecture: Architecture,
    layout: Layout,
    weights: Parameters,
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
        let (slots, layout) = architecture.layout();
        Self { architecture, layout, weights: Parameters::new(slots, seed) }
    }

    /// What fixes the shapes of the weights.
    pub fn architecture(&self) -> &Architecture {
        &self.architecture
    }

    /// All weights, flat, matrix after matrix in row-major order.
    pub fn weights(&self) -> Vec<f32> {
        self.weights.flat()
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
        self.weights.replace(weights);
    }

    /// Name of each weight matrix, and how many weights it holds, in the order of [`Network::weights`].
    pub fn matrices(&self) -> Vec<(String, usize)> {
        self.weights.names()
    }

    /// Each weight matrix with its name and shape, in the order of the flat list.
    #[cfg(test)]
    pub(super) fn named(&self) -> impl Iterator<Item = (&str, (usize, usize), &[f32])> {
        self.weights.named()
    }

    /// Writes every weight matrix by name, whole or not at all.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn save(&self, path: &Path) -> anyhow::Result<()> {
        save(&self.weights, &self.architecture, path)
    }

    /// Replaces the weights by those of a file that [`Network::save`] wrote for an equal architecture.
    ///
    /// # Errors
    /// A sentence naming the file, and the matrix with the shape it should have, when the file is missing, damaged, or of
    /// another architecture; the weights are then left as they were.
    pub fn load(&mut self, path: &Path) -> anyhow::Result<()> {
        let weights = load(&self.weights, &self.architecture, path)?;
        self.weights.replace(&weights);
        Ok(())
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
        let rows = entries(&output).to_vec();
        let mut grads = record.backward(output, at_output);
        let grad = self.collect(&mut grads, &leaves, weights);
        (rows, grad.expect("gradients of tensors that were just used fit in memory"))
    }

    fn collect(
        &self,
        grads: &mut Gradients<f32, Cpu>,
        leaves: &Leaves,
        weights: &mut [f32],
    ) -> Result<InputGrad, CpuError> {
        self.weights.collect(grads, weights)?;
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
        let (weight, bias) = self.weights.layer(round.update.first);
        let bias = Some(bias);
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
        let (weight, bias) = self.weights.layer(p.first);
        dense(record, rows, &[(x, weight, 0)], Some(bias), Finish::Squareplus)
    }

    fn last<T: Tape<f32, Cpu>>(
        &self,
        record: &mut Record<T>,
        rows: usize,
        x: &Matrix,
        p: &Perceptron,
        finish: Finish<'_>,
    ) -> Matrix {
        let (weight, bias) = self.weights.layer(p.last);
        dense(record, rows, &[(x, weight, 0)], Some(bias), finish)
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
