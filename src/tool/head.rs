//! The geometry of a tool's head as a config describes it.
use super::ToolSpec;
use crate::shape::read_mesh;
use crate::state::{Part, Solid, TriangleMesh};
use anyhow::{Context, ensure};
use glam::{DQuat, DVec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::path::{Path, PathBuf};
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

/// A solid, centred in its own frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum SolidSpec {
    /// A box.
    Cuboid {
        /// Half extents in x, y, z \[m\].
        half: [f64; 3],
    },
    /// A cylinder along y.
    Cylinder {
        /// Radius \[m\].
        #[schemars(range(min = 0.001, max = 1.0))]
        radius: f64,
        /// Half of its length \[m\].
        #[schemars(range(min = 0.001, max = 1.0))]
        half_length: f64,
    },
    /// A mesh from a file, moved so that its bounding box is centred.
    Mesh {
        /// An `.stl` file \[m\].
        path: PathBuf,
        /// Turn of the file's frame into the part's, an axis times an angle \[rad\].
        #[serde(default)]
        turn: [f64; 3],
    },
}

impl SolidSpec {
    /// The solid.
    ///
    /// # Errors
    /// When a size is not positive, or the mesh cannot be read.
    pub fn build(self) -> anyhow::Result<Solid> {
        match self {
            Self::Cuboid { half } => {
                ensure!(
                    half.iter().all(|h| *h > 0.0 && h.is_finite()),
                    "`solid.half` needs three positive lengths [m]"
                );
                Ok(Solid::Cuboid { half: DVec3::from_array(half) })
            }
            Self::Cylinder { radius, half_length } => {
                ensure!(
                    radius > 0.0 && half_length > 0.0 && radius.is_finite() && half_length.is_finite(),
                    "`solid.radius` and `solid.half_length` need positive lengths [m]"
                );
                Ok(Solid::Cylinder { radius, half_length })
            }
            Self::Mesh { path, turn } => {
                let mesh = read_mesh(&path)?;
                let turn = DQuat::from_scaled_axis(DVec3::from_array(turn));
                ensure!(turn.is_finite(), "`solid.turn` needs three finite numbers [rad]");
                let turned: Vec<DVec3> = mesh.vertices.iter().map(|v| turn * *v).collect();
                let (low, high) =
                    turned.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
                let centred = turned.iter().map(|v| v - (low + high) / 2.0).collect();
                let mesh = TriangleMesh::new(centred, mesh.triangles)
                    .with_context(|| format!("{} cannot be turned into a solid", path.display()))?;
                Ok(Solid::Mesh(Arc::new(mesh)))
            }
        }
    }
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
