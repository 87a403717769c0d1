//! The geometry of a tool's head as a config describes it.
use crate::state::{Part, Solid};
use anyhow::ensure;
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

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
}

impl SolidSpec {
    /// The solid.
    ///
    /// # Errors
    /// When a size is not positive.
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
        }
    }
}

impl HeadSpec {
    /// The part with its surface samples.
    ///
    /// # Errors
    /// When a size is not positive.
    pub fn build(self) -> anyhow::Result<Part> {
        ensure!(self.spacing > 0.0, "`spacing` is {}: surface samples need a positive distance [m]", self.spacing);
        let solid = self.solid.build()?;
        Ok(Part { surface: solid.surface(self.spacing), solid })
    }
}
