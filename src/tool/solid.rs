//! Solids as a config describes them.
use crate::shape::read_mesh;
use crate::state::{Placed, Pose, Solid, TriangleMesh};
use anyhow::{Context, ensure};
use glam::{DQuat, DVec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};
use std::path::{Path, PathBuf};
use std::sync::Arc;

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
    /// A tube along z, open at both ends: a ring of equal boxes.
    Tube {
        /// Radius of the wall's middle \[m\].
        #[schemars(range(min = 0.001, max = 1.0))]
        radius: f64,
        /// Thickness of the wall \[m\].
        #[schemars(range(min = 0.0005, max = 1.0))]
        wall: f64,
        /// Half of its height \[m\].
        #[schemars(range(min = 0.001, max = 1.0))]
        half_height: f64,
        /// Number of boxes.
        #[schemars(range(min = 3, max = 256))]
        sides: usize,
    },
    /// Several solids at fixed places.
    Assembly {
        /// The solids.
        pieces: Vec<PieceSpec>,
    },
}

/// A piece of an assembly.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PieceSpec {
    /// What it is; not an assembly itself.
    pub solid: SolidSpec,
    /// Where its middle lies \[m\].
    #[serde(default)]
    pub at: [f64; 3],
    /// How it is turned about its middle, an axis times an angle \[rad\].
    #[serde(default)]
    pub turn: [f64; 3],
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
            Self::Mesh { path, turn } => from_file(&path, turn),
            Self::Tube { radius, wall, half_height, sides } => tube(radius, wall, half_height, sides),
            Self::Assembly { pieces } => {
                ensure!(!pieces.is_empty(), "`solid.pieces` names no solid");
                let placed = pieces.into_iter().map(PieceSpec::build).collect::<anyhow::Result<Vec<_>>>()?;
                Ok(Solid::Assembly(placed.into()))
            }
        }
    }
}

impl PieceSpec {
    fn build(self) -> anyhow::Result<Placed> {
        let (translation, turn) = (DVec3::from_array(self.at), DVec3::from_array(self.turn));
        ensure!(
            translation.is_finite() && turn.is_finite(),
            "a piece's `at` and `turn` need three finite numbers each"
        );
        let solid = self.solid.build()?;
        ensure!(!matches!(solid, Solid::Assembly(_)), "a piece of an assembly must be a single solid");
        Ok(Placed { solid, pose: Pose { translation, rotation: DQuat::from_scaled_axis(turn) } })
    }
}

fn from_file(path: &Path, turn: [f64; 3]) -> anyhow::Result<Solid> {
    let mesh = read_mesh(path)?;
    let turn = DQuat::from_scaled_axis(DVec3::from_array(turn));
    ensure!(turn.is_finite(), "`solid.turn` needs three finite numbers [rad]");
    let turned: Vec<DVec3> = mesh.vertices.iter().map(|v| turn * *v).collect();
    let (low, high) = turned.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    let centred = turned.iter().map(|v| v - (low + high) / 2.0).collect();
    let mesh = TriangleMesh::new(centred, mesh.triangles)
        .with_context(|| format!("{} cannot be turned into a solid", path.display()))?;
    Ok(Solid::Mesh(Arc::new(mesh)))
}

/// Boxes as wide as the outer polygon's sides, so that neighbours overlap and no gap opens at the corners.
fn tube(radius: f64, wall: f64, half_height: f64, sides: usize) -> anyhow::Result<Solid> {
    let lengths = [radius, wall, half_height];
    ensure!(
        lengths.iter().all(|l| *l > 0.0 && l.is_finite()) && wall < 2.0 * radius,
        "`solid.radius`, `solid.wall` and `solid.half_height` need positive lengths [m], the wall thinner than the tube"
    );
    ensure!((3..=256).contains(&sides), "`solid.sides` must be between 3 and 256, got {sides}");
    let width = (radius + wall / 2.0) * (PI / sides as f64).tan();
    let side = |i: usize| {
        let rotation = DQuat::from_rotation_z(TAU * i as f64 / sides as f64);
        let solid = Solid::Cuboid { half: DVec3::new(wall / 2.0, width, half_height) };
        Placed { solid, pose: Pose { translation: rotation * (radius * DVec3::X), rotation } }
    };
    Ok(Solid::Assembly((0..sides).map(side).collect()))
}
