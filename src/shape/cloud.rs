//! A goal shape from a file of surface points.
use super::{FillSpec, Filled, Shape, read_points};
use anyhow::Context;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// The volume under the points of a file that holds the object alone; a camera's cloud with its table goes through perception.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CloudSpec {
    /// A `.ply`, `.npy`, `.npz` or `.stl` file \[m\].
    pub path: PathBuf,
    /// Height of the table in the file's coordinates \[m\]; that of the lowest point unless given.
    pub table: Option<f64>,
    /// How the volume is filled.
    pub fill: FillSpec,
}

impl CloudSpec {
    pub(crate) fn build(self) -> anyhow::Result<Filled> {
        let mut points = read_points(&self.path)?;
        let lowest = points.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
        let table = self.table.unwrap_or(lowest);
        points.iter_mut().for_each(|p| p.z -= table);
        let filled = Filled::under(&points, &self.fill).with_context(|| format!("in {}", self.path.display()))?;
        let (low, high) = filled.bounds();
        Ok(filled.moved(-(low + high).truncate() / 2.0))
    }
}
