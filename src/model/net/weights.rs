//! Weights on disk: safetensors with one named matrix a layer, and the architecture as metadata.
use super::parameters::Parameters;
use crate::config::write_whole;
use anyhow::{Context, bail, ensure};
use safetensors::tensor::{Dtype, SafeTensors, TensorView, serialize};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::collections::HashMap;
use std::fmt::Display;
use std::fs;
use std::path::Path;

const ARCHITECTURE: &str = "architecture";
const DAMAGED: &str = "the file is not whole safetensors; train again or copy it again";
const UNREADABLE: &str =
    "what the file says of its architecture makes no sense; it was changed, or is of another kind of network";

/// Writes every weight matrix by name, whole or not at all.
///
/// # Errors
/// When the file cannot be written.
pub(super) fn save(weights: &Parameters, architecture: &impl Serialize, path: &Path) -> anyhow::Result<()> {
    let matrices = weights.named().map(|(name, shape, values)| (name.to_owned(), shape, values)).collect();
    write_matrices(path, matrices, Some(serde_json::to_string(architecture)?))
}

/// The weights of a file that [`save`] wrote for an equal architecture.
///
/// # Errors
/// A sentence naming the file, and the matrix with the shape it should have, when the file is missing, damaged, of another
/// architecture, or says of its architecture what cannot be read; of a file that says nothing only the shapes are judged.
pub(super) fn load<A>(expected: &Parameters, architecture: &A, path: &Path) -> anyhow::Result<Vec<f32>>
where
    A: DeserializeOwned + PartialEq + Display,
{
    let bytes = fs::read(path).with_context(|| format!("cannot read the weights {}", path.display()))?;
    let read = read(expected, architecture, &bytes);
    read.with_context(|| format!("cannot use the weights {}", path.display()))
}

fn read<A>(expected: &Parameters, architecture: &A, bytes: &[u8]) -> anyhow::Result<Vec<f32>>
where
    A: DeserializeOwned + PartialEq + Display,
{
    let (_, header) = SafeTensors::read_metadata(bytes).context(DAMAGED)?;
    let stored = header.metadata().as_ref().and_then(|m| m.get(ARCHITECTURE));
    let stored = stored.map(|text| serde_json::from_str::<A>(text).context(UNREADABLE)).transpose();
    let stored = stored.with_context(|| format!("the config asks for {architecture}"))?;
    let file = SafeTensors::deserialize(bytes).context(DAMAGED)?;
    let shapes: Vec<_> = expected.named().map(|(name, shape, _)| (name.to_owned(), shape)).collect();
    let weights = matrices(&shapes, &file);
    if let Some(stored) = stored.filter(|s| s != architecture) {
        let story = format!("the file holds weights of {stored}, but the config asks for {architecture}");
        return weights.and_then(|_| bail!("the shapes fit, but not what is done with them")).context(story);
    }
    weights.with_context(|| format!("the config asks for {architecture}"))
}

/// Writes named matrices, whole or not at all, with the architecture where there is one to tell.
///
/// # Errors
/// When the file cannot be written.
pub(super) fn write_matrices(
    path: &Path,
    matrices: Vec<(String, (usize, usize), &[f32])>,
    architecture: Option<String>,
) -> anyhow::Result<()> {
    let bytes = |values: &[f32]| values.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let matrices: Vec<_> = matrices.into_iter().map(|(name, shape, values)| (name, shape, bytes(values))).collect();
    let views = matrices.iter().map(|(name, (rows, columns), bytes)| {
        let view = TensorView::new(Dtype::F32, vec![*rows, *columns], bytes);
        (name.as_str(), view.expect("as many bytes as the shape says"))
    });
    let metadata = architecture.map(|architecture| HashMap::from([(ARCHITECTURE.to_owned(), architecture)]));
    let bytes = serialize(views, metadata).with_context(|| format!("cannot encode {}", path.display()))?;
    write_whole(path, &bytes)
}

/// Reads matrices of these names and shapes, one after the other.
///
/// # Errors
/// A sentence naming the file, and the matrix with the shape it should have.
pub(super) fn read_matrices(path: &Path, shapes: &[(String, (usize, usize))]) -> anyhow::Result<Vec<f32>> {
    let bytes = fs::read(path).with_context(|| format!("cannot read the weights {}", path.display()))?;
    let file = SafeTensors::deserialize(&bytes).context(DAMAGED);
    file.and_then(|file| matrices(shapes, &file)).with_context(|| format!("cannot use the weights {}", path.display()))
}

fn matrices(shapes: &[(String, (usize, usize))], file: &SafeTensors<'_>) -> anyhow::Result<Vec<f32>> {
    let mut weights = Vec::new();
    for (name, (rows, columns)) in shapes {
        let found = file.tensor(name).ok();
        let found = found.with_context(|| format!("{name} is missing; expected shape [{rows}, {columns}]"))?;
        ensure!(
            found.dtype() == Dtype::F32 && found.shape() == [*rows, *columns],
            "{name} should be F32 of shape [{rows}, {columns}], found {:?} of shape {:?}",
            found.dtype(),
            found.shape()
        );
        let numbers = found.data().chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
        let before = weights.len();
        weights.extend(numbers);
        ensure!(weights[before..].iter().all(|x| x.is_finite()), "{name} holds a number that is not finite");
    }
    let extra = file.names().len().saturating_sub(shapes.len());
    ensure!(extra == 0, "the file holds {extra} matrices too many");
    Ok(weights)
}
