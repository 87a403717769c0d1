//! The weights of a network: matrices by name, how they start, and the one flat list that training sees.
use super::part::Part;
use super::record::{Matrix, entries};
use dfdx::prelude::{Cpu, CpuError, Gradients, TensorFromVec};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::ops::{Index, Range};

/// One weight matrix (a bias is a matrix of one row).
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Slot {
    name: String,
    shape: (usize, usize),
    deviation: f64,
}

/// Places in the list of slots of a two-layer perceptron.
#[derive(Clone, Debug)]
pub(super) struct Perceptron {
    pub(super) first: (usize, usize),
    pub(super) last: (usize, usize),
}

/// `1/σ` of a squareplus of a standard normal variable: restores unit variance behind the activation.
pub(super) const ACTIVE_GAIN: f64 = 1.852_76;

/// Every weight matrix in the order of the flat list.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Slots(Vec<Slot>);

impl Slots {
    /// `deviation = gain/√fan_in` keeps the variance of unit inputs (He et al. 2015, eq. 10, for our activation).
    pub(super) fn matrix(&mut self, name: &str, rows: usize, columns: usize, gain: f64) -> usize {
        let deviation = gain / (rows as f64).sqrt();
        self.0.push(Slot { name: name.to_owned(), shape: (rows, columns), deviation });
        self.0.len() - 1
    }

    /// Places of a weight and a bias.
    pub(super) fn layer(&mut self, name: &str, inputs: usize, outputs: usize, gain: f64) -> (usize, usize) {
        let weight = self.matrix(&format!("{name}.weight"), inputs, outputs, gain);
        (weight, self.matrix(&format!("{name}.bias"), 1, outputs, 0.0))
    }

    /// Two layers; the second behind an activation, `last` times as large as would keep the variance.
    pub(super) fn perceptron(
        &mut self,
        name: &str,
        inputs: usize,
        width: usize,
        outputs: usize,
        last: f64,
    ) -> Perceptron {
        Perceptron {
            first: self.layer(&format!("{name}.first"), inputs, width, 1.0),
            last: self.layer(&format!("{name}.last"), width, outputs, last * ACTIVE_GAIN),
        }
    }

    /// Number of weights.
    pub(super) fn count(&self) -> usize {
        self.0.iter().map(Slot::len).sum()
    }

    /// Normal weights from one ChaCha8 stream in the order of the list; those of no deviation, such as biases, are zero.
    fn start(&self, seed: u64) -> impl Iterator<Item = Vec<f32>> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut draw = move |deviation: f64| -> f32 {
            let normal: f64 = StandardNormal.sample(&mut rng);
            (deviation * normal) as f32
        };
        self.0.iter().map(move |slot| match slot.deviation {
            0.0 => vec![0.0; slot.len()],
            deviation => (0..slot.len()).map(|_| draw(deviation)).collect(),
        })
    }
}

impl Slot {
    fn len(&self) -> usize {
        self.shape.0 * self.shape.1
    }
}

/// Weight matrices and their names.
#[derive(Clone, Debug)]
pub(crate) struct Parameters {
    slots: Slots,
    matrices: Vec<Matrix>,
}

impl Parameters {
    /// Untrained weights, drawn from the stream of `seed`.
    pub(super) fn new(slots: Slots, seed: u64) -> Self {
        let device = Cpu::default();
        let starts = slots.start(seed).zip(&slots.0);
        let matrices = starts.map(|(values, slot)| device.tensor_from_vec(values, slot.shape)).collect();
        Self { slots, matrices }
    }

    /// Number of weights.
    pub(super) fn count(&self) -> usize {
        self.slots.count()
    }

    /// All weights, flat, matrix after matrix in row-major order.
    pub(super) fn flat(&self) -> Vec<f32> {
        self.matrices.iter().flat_map(|w| entries(w).iter().copied()).collect()
    }

    /// Replaces the weights by `weights`, laid out as [`Self::flat`].
    ///
    /// # Panics
    /// When their number is not [`Self::count`].
    pub(super) fn replace(&mut self, weights: &[f32]) {
        assert_eq!(weights.len(), self.count(), "as many weights as the architecture has");
        let mut rest = weights;
        for (matrix, slot) in self.matrices.iter_mut().zip(&self.slots.0) {
            let (own, after) = rest.split_at(slot.len());
            matrix.copy_from(own);
            rest = after;
        }
    }

    /// Each weight matrix with its name and shape, in the order of the flat list.
    pub(super) fn named(&self) -> impl Iterator<Item = (&str, (usize, usize), &[f32])> {
        self.slots.0.iter().zip(&self.matrices).map(|(slot, w)| (slot.name.as_str(), slot.shape, entries(w)))
    }

    /// Each weight matrix's name, and how many of the flat list are its own.
    pub(super) fn names(&self) -> Vec<(String, usize)> {
        self.slots.0.iter().map(|slot| (slot.name.clone(), slot.len())).collect()
    }

    /// A layer's weight, whole, and its bias.
    pub(super) fn layer(&self, (weight, bias): (usize, usize)) -> (Part, &Matrix) {
        (self.whole(weight), &self[bias])
    }

    /// Those rows of a weight matrix.
    pub(super) fn part(&self, weight: usize, rows: Range<usize>) -> Part {
        Part::new(&self[weight], rows)
    }

    /// All of a weight matrix.
    pub(super) fn whole(&self, weight: usize) -> Part {
        self.part(weight, 0..self.slots.0[weight].shape.0)
    }

    /// Adds the weights' gradients to `out`, laid out as [`Self::flat`], unless that slice is empty.
    pub(super) fn collect(&self, grads: &mut Gradients<f32, Cpu>, out: &mut [f32]) -> Result<(), CpuError> {
        if out.is_empty() {
            return Ok(());
        }
        let mut rest = out;
        for matrix in &self.matrices {
            let own = grads.get_or_alloc_mut(matrix)?;
            let (head, tail) = rest.split_at_mut(own.len());
            head.iter_mut().zip(own.iter()).for_each(|(w, g)| *w += g);
            rest = tail;
        }
        Ok(())
    }
}

impl Index<usize> for Parameters {
    type Output = Matrix;

    fn index(&self, slot: usize) -> &Matrix {
        &self.matrices[slot]
    }
}
