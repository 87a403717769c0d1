//! What a config says of the world.
use super::{Material, MaterialSpec, PieceSpec, StartSpec};
use crate::state::Wall;
use anyhow::{Context, ensure};
use glam::DVec3;
use indexmap::IndexMap;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Material on a table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SceneSpec {
    /// What it is made of, a file in `configs/material`.
    pub material: MaterialSpec,
    /// Shape and size at the start, drawn by seed.
    pub start: StartSpec,
    /// Distance between neighbouring particles of the simulator \[m\].
    #[schemars(range(min = 0.002, max = 0.1))]
    pub spacing: f64,
    /// Number of particles that models see: the farthest-point subset of the simulator's at the start. Of grains there are just as
    /// many.
    #[schemars(range(min = 1))]
    pub particles: usize,
    /// Duration of a control step \[s\].
    #[schemars(range(min = 0.001, max = 1.0))]
    pub interval: f64,
    /// How finely the simulator computes.
    pub solver: SolverSpec,
    /// Upright walls around the scene; without them the table goes on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub walls: Option<WallsSpec>,
    /// Further pieces by name, each of a material of its own.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub beside: IndexMap<String, PieceSpec>,
}

/// Where walls stand.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WallsSpec {
    /// The room between them along x \[m\].
    pub x: [f64; 2],
    /// The room between them along y \[m\].
    pub y: [f64; 2],
}

/// How finely the simulator computes: more of each is slower and closer to the material's own stiffness.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SolverSpec {
    /// Physics steps a control step: contacts are found and plastic flow happens once in each.
    #[schemars(range(min = 1, max = 1000))]
    pub steps: usize,
    /// Integration substeps a physics step.
    #[schemars(range(min = 1, max = 100))]
    pub substeps: usize,
    /// Gauss–Seidel sweeps a substep.
    #[schemars(range(min = 1, max = 100))]
    pub sweeps: usize,
}

impl WallsSpec {
    /// The walls as planes.
    pub(super) fn planes(&self) -> Vec<Wall> {
        let pair = |(axis, [low, high]): (DVec3, [f64; 2])| {
            [Wall { normal: axis, offset: low }, Wall { normal: -axis, offset: -high }]
        };
        [(DVec3::X, self.x), (DVec3::Y, self.y)].into_iter().flat_map(pair).collect()
    }
}

impl SceneSpec {
    /// The materials, its own and then those beside it, once every number that serde cannot check is checked.
    ///
    /// # Errors
    /// A sentence naming the key whose value is impossible.
    pub(super) fn check(&self) -> anyhow::Result<Vec<Box<dyn Material>>> {
        let mut materials = vec![self.material.clone().build()?];
        for (name, piece) in &self.beside {
            materials.push(piece.check().with_context(|| format!("in scene.beside.{name}"))?);
        }
        let Self { spacing, particles, interval, solver, walls, .. } = self;
        ensure!((0.002..=0.1).contains(spacing), "scene.spacing is {spacing} m; it must lie in [0.002, 0.1]");
        ensure!((0.001..=1.0).contains(interval), "scene.interval is {interval} s; it must lie in [0.001, 1]");
        ensure!(*particles > 0, "scene.particles is 0; models need at least one particle");
        for (key, value, most) in
            [("steps", solver.steps, 1000), ("substeps", solver.substeps, 100), ("sweeps", solver.sweeps, 100)]
        {
            ensure!((1..=most).contains(&value), "scene.solver.{key} is {value}; it must lie in [1, {most}]");
        }
        for (key, [low, high]) in walls.iter().flat_map(|walls| [("x", walls.x), ("y", walls.y)]) {
            ensure!(
                low < high && (high - low).is_finite(),
                "scene.walls.{key} = [{low}, {high}] must be [low, high] with low < high [m]"
            );
        }
        Ok(materials)
    }
}
