//! What laws remember of pairs from substep to substep: one memory for bonds and for the springs of friction.
use super::{View, ViewGrad};
use crate::state::{Particles, ParticlesGrad};

/// Internal variables of pairs (Simo & Hughes 1998, section 1.2): as many numbers for each, pairs in ascending order.
///
/// Who the two are is for the law to say; what is no longer listed is forgotten.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct History {
    pairs: Vec<[u32; 2]>,
    values: Vec<f64>,
}

impl History {
    /// Of a law that remembers nothing.
    pub const NONE: &'static Self = &Self { pairs: Vec::new(), values: Vec::new() };

    /// Adds a pair behind those there are.
    pub fn push(&mut self, pair: [u32; 2], values: &[f64]) {
        debug_assert!(self.pairs.last().is_none_or(|last| *last < pair), "pairs come in ascending order");
        self.pairs.push(pair);
        self.values.extend_from_slice(values);
    }

    /// The pairs.
    pub fn pairs(&self) -> &[[u32; 2]] {
        &self.pairs
    }

    /// All numbers, pair by pair.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Place of a pair, where it is remembered.
    pub fn place(&self, pair: [u32; 2]) -> Option<usize> {
        self.pairs.binary_search(&pair).ok()
    }

    /// The numbers of the pair at `place`, N for each.
    pub fn row<const N: usize>(&self, place: usize) -> [f64; N] {
        std::array::from_fn(|k| self.values[N * place + k])
    }
}

/// A law that remembers: its acceleration follows from [`View::history`], which it renews before each time that it is asked.
pub trait Remember {
    /// What is remembered of particles and the numbers of their bodies where a rollout starts.
    fn begin(&self, particles: &Particles, body: &[u32]) -> History {
        let _ = (particles, body);
        History::default()
    }
    /// Adds `∂J/∂particles` to `grad` from `at` = `∂J/∂(numbers of begin)`.
    fn begin_vjp(&self, particles: &Particles, history: &History, at: &[f64], grad: &mut ParticlesGrad) {
        let _ = (particles, history, at, grad);
    }
    /// What is remembered of `view` a `duration` \[s\] after what its history holds.
    fn advance(&self, view: &View<'_>, duration: f64) -> History;
    /// Adds `∂J/∂view`, its history included, to `grad` from `at` = `∂J/∂(numbers of advance)`.
    fn advance_vjp(&self, view: &View<'_>, duration: f64, at: &[f64], grad: &mut ViewGrad<'_>);
    /// Adds `∂J/∂constants`, in the order of the law's, to `constants` from the same.
    fn advance_constants_vjp(&self, view: &View<'_>, duration: f64, at: &[f64], constants: &mut [f64]);
}
