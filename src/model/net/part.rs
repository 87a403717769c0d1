//! The rows of a weight matrix that one input meets.
use super::product::{Block, multiply, multiply_add};
use super::record::{Matrix, entries, gradient};
use super::rounded::Rounded;
use dfdx::prelude::{Cpu, CpuError, Gradients, HasShape};
use std::ops::Range;
use std::sync::Arc;

/// W, some rows of a weight matrix: several inputs side by side each meet their own, `[x₁, x₂] [W₁; W₂] = x₁ W₁ + x₂ W₂`.
#[derive(Clone)]
pub(super) struct Part {
    weight: Matrix,
    rows: Range<usize>,
    rounded: Option<Arc<Rounded>>,
}

impl Part {
    /// Those `rows` of `weight`.
    pub(super) fn new(weight: &Matrix, rows: Range<usize>) -> Self {
        assert!(rows.end <= weight.shape().0, "rows {rows:?} of {}", weight.shape().0);
        Self { weight: weight.clone(), rows, rounded: None }
    }

    /// The same, its products rounded.
    pub(super) fn with(self, rounded: Option<Arc<Rounded>>) -> Self {
        Self { rounded, ..self }
    }

    /// Its rounded weights, where its products are rounded.
    pub(super) fn rounded(&self) -> Option<&Rounded> {
        self.rounded.as_deref()
    }

    /// Numbers of a row of what comes out.
    pub(super) fn columns(&self) -> usize {
        self.weight.shape().1
    }

    fn place(&self) -> Range<usize> {
        self.rows.start * self.columns()..self.rows.end * self.columns()
    }

    fn block(&self) -> Block<'_> {
        Block::new(&entries(&self.weight)[self.place()], self.columns())
    }

    fn input<'a>(&self, x: &'a [f32]) -> Block<'a> {
        Block::new(x, self.rows.len())
    }

    /// `out = x W`, x of whole rows.
    pub(super) fn multiply(&self, x: &[f32], out: &mut [f32]) {
        match &self.rounded {
            Some(rounded) => rounded.multiply(x, out),
            None => multiply(self.input(x), self.block(), out),
        }
    }

    /// `out += x W`.
    pub(super) fn multiply_add(&self, x: &[f32], out: &mut [f32]) {
        match &self.rounded {
            Some(rounded) => rounded.multiply_add(x, out),
            None => multiply_add(self.input(x), self.block(), out),
        }
    }

    /// `at_x = δ Wᵀ`.
    pub(super) fn pull(&self, delta: &[f32], at_x: &mut [f32]) {
        match &self.rounded {
            Some(rounded) => rounded.multiply_transposed(delta, at_x),
            None => multiply(Block::new(delta, self.columns()), self.block().transposed(), at_x),
        }
    }

    /// `at_x += δ Wᵀ`.
    pub(super) fn pull_add(&self, delta: &[f32], at_x: &mut [f32]) {
        match &self.rounded {
            Some(rounded) => rounded.multiply_transposed_add(delta, at_x),
            None => multiply_add(Block::new(delta, self.columns()), self.block().transposed(), at_x),
        }
    }

    /// `∂J/∂W += xᵀ δ`.
    pub(super) fn learn(&self, x: &[f32], delta: &[f32], grads: &mut Gradients<f32, Cpu>) -> Result<(), CpuError> {
        let at_weight = &mut gradient(grads, &self.weight)?[self.place()];
        multiply_add(self.input(x).transposed(), Block::new(delta, self.columns()), at_weight);
        Ok(())
    }
}
