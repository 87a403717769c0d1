//! The geometry of a tool's head as a config describes it.
use super::{SolidSpec, ToolSpec};
use crate::state::{Part, ToolShape};
use anyhow::ensure;
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::path::Path;
use std::sync::Arc;

/// A rigid head: its solid, and how densely its surface is sampled for graphs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HeadSpec {
    /// What collides.
    pub solid: SolidSpec,
    /// Distance between neighbouring surface samples \[m\].
    #[schemars(range(min = 0.001, max = 0.1))]
    pub spacing: f64,
}

impl HeadSpec {
    /// The part with its surface samples.
    ///
    /// # Errors
    /// When a size is not positive, or the mesh cannot be read.
    pub fn build(self) -> anyhow::Result<Part> {
        ensure!(self.spacing > 0.0, "`spacing` is {}: surface samples need a positive distance [m]", self.spacing);
        let solid = self.solid.build()?;
        Ok(Part { surface: solid.surface(self.spacing), solid })
    }
}

/// The only part of a tool.
#[derive(Clone, Debug)]
pub(super) struct Head {
    /// The tool's geometry.
    pub(super) shape: Arc<ToolShape>,
    /// Its half extents \[m\].
    pub(super) half: DVec3,
}

impl HeadSpec {
    /// The tool that this head alone makes.
    pub(super) fn alone(self) -> anyhow::Result<Head> {
        let part = self.build()?;
        Ok(Head { half: part.solid.half_extents(), shape: Arc::new(ToolShape::from(vec![part])) })
    }
}

impl ToolSpec {
    /// The same tool with every relative mesh path taken from the folder `root`.
    pub fn under(&self, root: &Path) -> Self {
        let mut tree = serde_json::to_value(self).expect("a spec is plain data");
        move_meshes(&mut tree, root);
        serde_json::from_value(tree).expect("only paths were changed")
    }
}

/// Whatever the primitive calls its heads, a mesh is a table with a `path` in it.
fn move_meshes(tree: &mut Value, root: &Path) {
    match tree {
        Value::Object(table) => {
            if let Some(Value::String(path)) = table.get_mut("path") {
                *path = root.join(&*path).to_string_lossy().into_owned();
            }
            table.values_mut().for_each(|below| move_meshes(below, root));
        }
        Value::Array(items) => items.iter_mut().for_each(|below| move_meshes(below, root)),
        _ => {}
    }
}
