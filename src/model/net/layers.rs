//! Networks that map matrices to one matrix: their forward pass and their vector–Jacobian product, written once.
use super::parameters::Parameters;
use super::record::{Matrix, Record, Wanted, entries};
use super::weights;
use dfdx::prelude::{Cpu, CpuError, NoneTape, OwnedTape, Tape};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fmt::Display;
use std::path::Path;

/// Dense and [mixing](super::mixing::mix) layers in some order.
pub(crate) trait Layers {
    /// The weights that they belong to.
    fn owner(&self) -> &Parameters;
    /// The output, recorded.
    fn run<T: Tape<f32, Cpu>>(&self, record: &mut Record<T>, inputs: &[Matrix]) -> Matrix;
}

/// A network whose weights are trained and lie on disk.
pub(crate) trait Trainable {
    /// What fixes its weights' shapes; weights of an equal one can be exchanged.
    type Architecture: Serialize + DeserializeOwned + PartialEq + Display;

    fn architecture(&self) -> &Self::Architecture;
    fn parameters(&self) -> &Parameters;
    fn parameters_mut(&mut self) -> &mut Parameters;

    /// All weights, flat.
    fn weights(&self) -> Vec<f32> {
        self.parameters().flat()
    }

    /// Replaces the weights by `weights`, laid out as [`Trainable::weights`].
    fn set_weights(&mut self, weights: &[f32]) {
        self.parameters_mut().replace(weights);
    }

    /// Name of each weight matrix, and how many weights it holds, in the order of [`Trainable::weights`].
    fn matrices(&self) -> Vec<(String, usize)> {
        self.parameters().names()
    }

    /// Writes every weight matrix by name, whole or not at all.
    fn save(&self, path: &Path) -> anyhow::Result<()> {
        weights::save(self.parameters(), self.architecture(), path)
    }

    /// The same with the weights of a file that [`Trainable::save`] wrote, or as it is where none is named.
    fn loaded(mut self, path: Option<&Path>) -> anyhow::Result<Self>
    where
        Self: Sized,
    {
        let Some(path) = path else { return Ok(self) };
        let read = weights::load(self.parameters(), self.architecture(), path)?;
        self.set_weights(&read);
        Ok(self)
    }
}

/// An input: its numbers, row after row, and how many a row has.
pub(crate) type Rows = (Vec<f32>, usize);

/// The output, row after row.
pub(crate) fn forward(layers: &impl Layers, inputs: Vec<Rows>) -> Vec<f32> {
    let mut record = Record::<NoneTape>::new(Wanted::Inputs);
    let inputs: Vec<Matrix> = inputs.into_iter().map(|(rows, columns)| record.matrix(rows, columns)).collect();
    entries(&layers.run(&mut record, &inputs)).to_vec()
}

/// The output, and `∂J/∂input` of every input from `∂J/∂output`; adds `∂J/∂weights` to `weights` unless that slice is empty.
pub(crate) fn pull(
    layers: &impl Layers,
    inputs: Vec<Rows>,
    at_output: &[f32],
    weights: &mut [f32],
) -> (Vec<f32>, Vec<Vec<f32>>) {
    if at_output.is_empty() {
        return (Vec::new(), inputs.iter().map(|(rows, _)| vec![0.0; rows.len()]).collect());
    }
    let wanted = Wanted::of(weights);
    let mut record = Record::<OwnedTape<f32, Cpu>>::new(wanted);
    let inputs: Vec<Matrix> = inputs.into_iter().map(|(rows, columns)| record.matrix(rows, columns)).collect();
    let output = layers.run(&mut record, &inputs);
    let rows = entries(&output).to_vec();
    let mut grads = record.backward(output, at_output);
    let mut collect = || -> Result<Vec<Vec<f32>>, CpuError> {
        layers.owner().collect(&mut grads, weights)?;
        inputs.iter().map(|x| Ok(std::mem::take(&mut **grads.get_or_alloc_mut(x)?))).collect()
    };
    (rows, collect().expect("gradients of tensors that were just used fit in memory"))
}
