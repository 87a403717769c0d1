//! The network's weights, its forward pass and its vector–Jacobian product.
use super::aggregate::{Sums, aggregate};
use super::architecture::{Architecture, Layout, Round};
use super::dense::{Finish, dense};
use super::ends::Ends;
use super::input::{EDGE_FEATURES, Edges, Input, InputGrad};
use super::layer_norm::layer_norm;
use super::message::{EdgeInput, Weights, message};
use super::parameters::{Parameters, Perceptron};
use super::part::Part;
use super::precision::Precision;
use super::record::{Matrix, Record, Wanted, entries};
use super::rounded::Rounded;
use super::traced::{Leaves, Traced};
use super::weights::{load, save};
use dfdx::prelude::{Cpu, HasShape, NoneTape, OwnedTape, Tape};
use std::ops::Range;
use std::path::Path;
use std::sync::{Arc, OnceLock};

/// A typed message-passing network: nodes and edges in, three numbers a particle out.
#[derive(Clone, Debug)]
pub struct Network {
    architecture: Architecture,
    layout: Layout,
    weights: Parameters,
    precision: Precision,
    /// Of every weight matrix of W columns its blocks of as many rows, rounded when first asked for.
    rounded: OnceLock<Vec<Vec<Arc<Rounded>>>>,
}

/// How many rows, from the first, get an output, and how many get messages.
struct Rows {
    particles: usize,
    receivers: usize,
}

impl Network {
    /// A network whose weights are drawn from the stream of `seed`; its output is zero until the last layer is trained.
    pub fn new(architecture: Architecture, seed: u64) -> Self {
        let (slots, layout) = architecture.layout();
        let weights = Parameters::new(slots, seed);
        Self { architecture, layout, weights, precision: Precision::default(), rounded: OnceLock::new() }
    }

    /// The same, predicting in this precision.
    pub fn in_precision(self, precision: Precision) -> Self {
        Self { precision, ..self }
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
        self.rounded = OnceLock::new();
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
        self.set_weights(&weights);
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
        let wanted = Wanted::of(weights);
        let traced = self.trace(input, wanted);
        (traced.output().to_vec(), traced.pull(at_output, weights))
    }

    /// The output, with what its derivatives need.
    pub fn trace(&self, input: Input, wanted: Wanted) -> Traced<'_> {
        let mut record = Record::<OwnedTape<f32, Cpu>>::new(wanted);
        let (rows, leaves) = self.leaves(&record, input);
        let output = self.run(&mut record, &rows, &leaves);
        Traced { architecture: &self.architecture, weights: &self.weights, record, leaves, output }
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
        let nodes = self.norm(record, &nodes, self.layout.norm);
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
        let width = self.architecture.width;
        let base = nodes;
        let nodes = &self.norm(record, base, round.norm);
        let mut kinds = Vec::new();
        for (network, edges) in round.edges.iter().zip(edges) {
            if !edges.links.is_empty() {
                let first = |rows| self.part(record.wanted, network.first.0, rows);
                let weights = Weights {
                    receiver: first(0..width),
                    sender: first(width..2 * width),
                    edge: first(2 * width..2 * width + EDGE_FEATURES),
                    first_bias: self.weights[network.first.1].clone(),
                    flag: network.flag.map(|row| first(row..row + 1)),
                    hidden: self.part(record.wanted, network.hidden.0, 0..width),
                    hidden_bias: self.weights[network.hidden.1].clone(),
                };
                let sums = message(record, nodes, edges, &weights, self.architecture.aggregation);
                let last = self.part(record.wanted, network.last, 0..width);
                kinds.push(Sums { receivers: Arc::clone(&edges.receivers), sums, last });
            }
        }
        let (weight, bias) = round.update.first;
        let own = self.part(record.wanted, weight, 0..width);
        let bias = Some(&self.weights[bias]);
        // Without edges the sum of messages is exactly zero and its product is left out.
        let inner = if kinds.is_empty() {
            dense(record, receivers, &[(nodes, own)], bias, Finish::Squareplus)
        } else {
            let aggregate = aggregate(record, receivers, kinds);
            let terms = [(nodes, own), (&aggregate, self.part(record.wanted, weight, width..2 * width))];
            dense(record, receivers, &terms, bias, Finish::Squareplus)
        };
        self.last(record, receivers, &inner, &round.update, Finish::Onto(base))
    }

    /// The rows as networks read them.
    fn norm<T: Tape<f32, Cpu>>(&self, record: &mut Record<T>, x: &Matrix, norm: Option<(usize, usize)>) -> Matrix {
        match norm {
            Some((gain, shift)) => layer_norm(record, x, &self.weights[gain], &self.weights[shift]),
            None => x.clone(),
        }
    }

    fn layer<T: Tape<f32, Cpu>>(&self, record: &mut Record<T>, rows: usize, x: &Matrix, p: &Perceptron) -> Matrix {
        self.affine(record, rows, x, p.first, Finish::Squareplus)
    }

    fn last<T: Tape<f32, Cpu>>(
        &self,
        record: &mut Record<T>,
        rows: usize,
        x: &Matrix,
        p: &Perceptron,
        finish: Finish<'_>,
    ) -> Matrix {
        self.affine(record, rows, x, p.last, finish)
    }

    fn affine<T: Tape<f32, Cpu>>(
        &self,
        record: &mut Record<T>,
        rows: usize,
        x: &Matrix,
        (weight, bias): (usize, usize),
        finish: Finish<'_>,
    ) -> Matrix {
        let part = self.part(record.wanted, weight, 0..x.shape().1);
        dense(record, rows, &[(x, part)], Some(&self.weights[bias]), finish)
    }

    /// Some rows of a weight matrix, rounded where the precision says so and both sides of it are hidden layers.
    fn part(&self, wanted: Wanted, weight: usize, rows: Range<usize>) -> Part {
        let width = self.architecture.width;
        let rounded = match (self.precision, wanted) {
            (Precision::Bfloat16, Wanted::Inputs) if rows.len() == width => {
                let blocks = &self.rounded.get_or_init(|| self.round_off())[weight];
                blocks.get(rows.start / width).cloned()
            }
            _ => None,
        };
        self.weights.part(weight, rows).with(rounded)
    }

    fn round_off(&self) -> Vec<Vec<Arc<Rounded>>> {
        let width = self.architecture.width;
        let blocks = |(_, (_, columns), weight): (&str, (usize, usize), &[f32])| -> Vec<Arc<Rounded>> {
            let own = if columns == width { weight } else { &[] };
            own.chunks_exact(width * width).map(|block| Arc::new(Rounded::new(block, width))).collect()
        };
        self.weights.named().map(blocks).collect()
    }

    fn leaves<T: Tape<f32, Cpu>>(&self, record: &Record<T>, input: Input) -> (Rows, Leaves) {
        let edge = |e: Edges| EdgeInput {
            receivers: Arc::new(Ends::new(&e.links.receivers)),
            senders: Arc::new(Ends::new(&e.links.senders)),
            links: e.links,
            features: record.matrix(e.features, EDGE_FEATURES),
            window: record.matrix(e.window, 1),
        };
        let edges = input.edges.into_iter().map(edge).collect();
        let rows = Rows { particles: input.particles, receivers: input.receivers };
        (rows, Leaves { nodes: record.matrix(input.nodes, self.architecture.node_features()), edges })
    }
}
