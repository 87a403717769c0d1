//! Perceptrons of two hidden layers in f64, small enough to be asked in every substep, with exact derivatives.
use super::product::{Block, multiply, multiply_add};
use super::squareplus::double::{slope, squareplus};
use super::weights::{read_matrices, write_matrices};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::path::Path;

/// `σ(σ(x W₁ + b₁) W₂ + b₂) W₃`, rows x; weights are stored as f32 and used as f64.
#[derive(Clone, Debug)]
pub(crate) struct MultilayerPerceptron {
    /// Inputs, width, outputs.
    sizes: [usize; 3],
    /// W₁, b₁, W₂, b₂, W₃, one after the other.
    weights: Vec<f64>,
}

/// What a forward pass leaves.
pub(crate) struct Activations {
    inputs: Vec<f64>,
    first: Vec<f64>,
    second: Vec<f64>,
    outputs: Vec<f64>,
    columns: usize,
}

impl Activations {
    /// The outputs, a row each.
    pub(crate) fn rows(&self) -> impl Iterator<Item = &[f64]> {
        self.outputs.chunks_exact(self.columns)
    }
}

impl MultilayerPerceptron {
    /// Number of weights.
    pub(crate) fn weight_count(&self) -> usize {
        self.weights.len()
    }

    /// Rows and columns of each matrix, by the name of its layer.
    fn shapes([inputs, width, outputs]: [usize; 3]) -> [(&'static str, (usize, usize)); 5] {
        [
            ("first.weight", (inputs, width)),
            ("first.bias", (1, width)),
            ("hidden.weight", (width, width)),
            ("hidden.bias", (1, width)),
            ("last.weight", (width, outputs)),
        ]
    }

    fn new(sizes: [usize; 3], rng: &mut ChaCha8Rng) -> Self {
        let mut weights = Vec::new();
        for (name, (rows, columns)) in Self::shapes(sizes) {
            // Biases and the last layer are zero; the others keep the variance of their inputs.
            let deviation =
                if name == "first.weight" || name == "hidden.weight" { (rows as f64).sqrt().recip() } else { 0.0 };
            for _ in 0..rows * columns {
                let normal: f64 = StandardNormal.sample(rng);
                weights.push(f64::from((deviation * normal) as f32));
            }
        }
        Self { sizes, weights }
    }

    /// W₁, b₁, W₂, b₂, W₃.
    fn parts(&self) -> [&[f64]; 5] {
        let mut rest = &self.weights[..];
        Self::shapes(self.sizes).map(|(_, (rows, columns))| {
            let (own, after) = rest.split_at(rows * columns);
            rest = after;
            own
        })
    }

    /// The outputs of rows of inputs.
    pub(crate) fn forward(&self, inputs: Vec<f64>) -> Activations {
        let [columns, width, outputs] = self.sizes;
        let [w1, b1, w2, b2, w3] = self.parts();
        let rows = inputs.len() / columns;
        let layer = |x: &[f64], inner: usize, w: &[f64], b: &[f64]| {
            let mut out = vec![0.0; rows * width];
            multiply(Block::new(x, inner), Block::new(w, width), &mut out);
            for row in out.chunks_exact_mut(width) {
                row.iter_mut().zip(b).for_each(|(x, b)| *x = squareplus(*x + b));
            }
            out
        };
        let first = layer(&inputs, columns, w1, b1);
        let second = layer(&first, width, w2, b2);
        let mut out = vec![0.0; rows * outputs];
        multiply(Block::new(&second, width), Block::new(w3, outputs), &mut out);
        Activations { inputs, first, second, outputs: out, columns: outputs }
    }

    /// `∂J/∂inputs` from `∂J/∂outputs`; adds `∂J/∂weights` to `weights` unless that slice is empty.
    pub(crate) fn pull(&self, left: &Activations, at: &[f64], weights: &mut [f32]) -> Vec<f64> {
        let [columns, width, outputs] = self.sizes;
        let [w1, _, w2, _, w3] = self.parts();
        let rows = at.len() / outputs;
        let back = |at: &[f64], inner: usize, w: &[f64], active: &[f64]| {
            let mut out = vec![0.0; rows * width];
            multiply(Block::new(at, inner), Block::new(w, inner).transposed(), &mut out);
            out.iter_mut().zip(active).for_each(|(g, y)| *g *= slope(*y));
            out
        };
        let at_second = back(at, outputs, w3, &left.second);
        let at_first = back(&at_second, width, w2, &left.first);
        if !weights.is_empty() {
            let mut sums = vec![0.0; self.weights.len()];
            let mut rest = &mut sums[..];
            let pairs = [
                (&left.inputs, columns, &at_first[..], width),
                (&left.first, width, &at_second[..], width),
                (&left.second, width, at, outputs),
            ];
            for (k, (x, inner, delta, outer)) in pairs.into_iter().enumerate() {
                let (own, after) = rest.split_at_mut(inner * outer);
                multiply_add(Block::new(x, inner).transposed(), Block::new(delta, outer), own);
                // The last layer has no bias.
                let (bias, after) = after.split_at_mut(if k < 2 { outer } else { 0 });
                for row in delta.chunks_exact(outer) {
                    bias.iter_mut().zip(row).for_each(|(b, g)| *b += g);
                }
                rest = after;
            }
            weights.iter_mut().zip(sums).for_each(|(w, g)| *w += g as f32);
        }
        let mut at_inputs = vec![0.0; rows * columns];
        multiply(Block::new(&at_first, width), Block::new(w1, width).transposed(), &mut at_inputs);
        at_inputs
    }
}

/// Perceptrons side by side, each under a name.
#[derive(Clone, Debug)]
pub(crate) struct Stack {
    names: Vec<String>,
    networks: Vec<MultilayerPerceptron>,
}

impl Stack {
    /// Of inputs, width and outputs alike, drawn from the stream of `seed`; their outputs are zero until the last layer is trained.
    pub(crate) fn new(names: &[String], sizes: [usize; 3], seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let networks = names.iter().map(|_| MultilayerPerceptron::new(sizes, &mut rng)).collect();
        Self { names: names.to_vec(), networks }
    }

    /// Each of them.
    pub(crate) fn networks(&self) -> &[MultilayerPerceptron] {
        &self.networks
    }

    /// Whether every output is zero whatever the input.
    pub(crate) fn is_silent(&self) -> bool {
        self.networks.iter().all(|network| network.parts()[4].iter().all(|w| *w == 0.0))
    }

    /// All weights, flat.
    pub(crate) fn weights(&self) -> Vec<f32> {
        self.networks.iter().flat_map(|network| network.weights.iter().map(|w| *w as f32)).collect()
    }

    /// Replaces the weights by `weights`, laid out as [`Stack::weights`].
    ///
    /// # Panics
    /// When their number is another.
    pub(crate) fn set_weights(&mut self, weights: &[f32]) {
        let own = self.networks.iter_mut().flat_map(|network| &mut network.weights);
        assert_eq!(weights.len(), own.zip(weights).map(|(own, w)| *own = f64::from(*w)).count(), "as many weights");
    }

    /// Name of each weight matrix, and how many weights it holds, in the order of [`Stack::weights`].
    pub(crate) fn matrices(&self) -> Vec<(String, usize)> {
        self.shapes().map(|(name, (rows, columns))| (name, rows * columns)).collect()
    }

    /// Writes every weight matrix by name, whole or not at all.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub(crate) fn save(&self, path: &Path) -> anyhow::Result<()> {
        let weights = self.weights();
        let mut rest = &weights[..];
        let matrices = self.shapes().map(|(name, shape)| {
            let (own, after) = rest.split_at(shape.0 * shape.1);
            rest = after;
            (name, shape, own)
        });
        write_matrices(path, matrices.collect::<Vec<_>>(), None)
    }

    /// Replaces the weights by those of a file that [`Stack::save`] wrote for the same names and sizes.
    ///
    /// # Errors
    /// A sentence naming the file, and the matrix with the shape it should have; the weights are then left as they were.
    pub(crate) fn load(&mut self, path: &Path) -> anyhow::Result<()> {
        let weights = read_matrices(path, &self.shapes().collect::<Vec<_>>())?;
        self.set_weights(&weights);
        Ok(())
    }

    /// Names and shapes of all matrices, in the order of the flat layout.
    fn shapes(&self) -> impl Iterator<Item = (String, (usize, usize))> + '_ {
        self.names.iter().zip(&self.networks).flat_map(|(name, network)| {
            MultilayerPerceptron::shapes(network.sizes).map(|(layer, shape)| (format!("edge.{name}.{layer}"), shape))
        })
    }
}
