//! A cylinder that comes down, rolls over the material without slip, and lifts again.
use super::leg::{Leg, along};
use super::{HeadSpec, Motion, Tool, Workpiece};
use crate::state::{ActionSpace, Control, Pose, ToolShape};
use anyhow::ensure;
use glam::{DQuat, DVec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A roller: θ = (x, y, z, rotation), as RoboCook (Shi et al. 2023) parametrises it.
///
/// The cylinder comes down on `centre + (x, y)` until its lowest line is at height `z`, between half of the workpiece's
/// height and all of it, then rolls `length` along (cos rotation, sin rotation), turning by `length / radius`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RollSpec {
    /// The roller; its axle is the local y axis.
    pub head: HeadSpec,
    /// Bound of |x| and |y| \[m\].
    #[schemars(range(min = 0.0, max = 0.5))]
    pub reach: f64,
    /// Least height of the roller's lowest line above the table \[m\].
    #[schemars(range(min = 0.0005, max = 0.1))]
    pub lowest: f64,
    /// Bound of |rotation| \[rad\].
    #[schemars(range(min = 0.0, max = std::f64::consts::PI))]
    pub rotation: f64,
    /// Length of the stroke \[m\].
    #[schemars(range(min = 0.0, max = 1.0))]
    pub length: f64,
    /// Distance kept above the workpiece at the start and at the end \[m\].
    #[schemars(range(min = 0.001, max = 0.1))]
    pub clearance: f64,
    /// Share of the steps in which the roller comes down.
    #[schemars(range(min = 1, max = 100))]
    pub down: usize,
    /// Share of the steps in which it rolls.
    #[schemars(range(min = 1, max = 100))]
    pub roll: usize,
    /// Share of the steps in which it lifts.
    #[schemars(range(min = 1, max = 100))]
    pub lift: usize,
}

/// See [`RollSpec`].
#[derive(Clone, Debug)]
pub struct Roll {
    spec: RollSpec,
    shape: Arc<ToolShape>,
    radius: f64,
}

impl RollSpec {
    /// The roller.
    ///
    /// # Errors
    /// When a size is impossible.
    pub fn build(self) -> anyhow::Result<Roll> {
        ensure!(self.lowest > 0.0, "`lowest` must be positive, or material is squeezed through the table");
        ensure!(self.clearance > 0.0, "`clearance` must be positive");
        ensure!(self.length >= 0.0, "`length` must not be negative");
        ensure!(self.down > 0 && self.roll > 0 && self.lift > 0, "`down`, `roll`, `lift` need at least one step each");
        let head = self.head.clone().build()?;
        let half = head.solid.half_extents();
        ensure!((half.x - half.z).abs() <= 0.02 * half.x, "the roller `head` must be round about its y axis");
        Ok(Roll { shape: Arc::new(ToolShape::from(vec![head])), radius: half.x.max(half.z), spec: self })
    }
}

impl Tool for Roll {
    fn shape(&self) -> &Arc<ToolShape> {
        &self.shape
    }

    fn space(&self, piece: &Workpiece) -> ActionSpace {
        let RollSpec { reach, rotation, lowest, .. } = self.spec;
        let low = (piece.extent.z / 2.0).max(lowest);
        ActionSpace {
            names: ["x", "y", "z", "rotation"].map(String::from).to_vec(),
            low: vec![-reach, -reach, low, -rotation],
            high: vec![reach, reach, piece.extent.z.max(low), rotation],
        }
    }

    fn motion(&self, theta: &[f64], piece: &Workpiece, steps: usize) -> Motion {
        let &[x, y, z, rotation] = theta else { panic!("a roller takes four numbers, not {theta:?}") };
        let clear = piece.extent.z.max(self.spec.lowest) + self.spec.clearance;
        let (sine, cosine) = rotation.sin_cos();
        let head = |[line, rolled]: [f64; 2]| {
            let translation = piece.centre + DVec3::new(x + rolled * cosine, y + rolled * sine, line + self.radius);
            // The lowest line stands still when the top moves forward: a positive turn about the axle.
            let rotation = DQuat::from_rotation_z(rotation) * DQuat::from_rotation_y(rolled / self.radius);
            vec![Pose { translation, rotation }]
        };
        let RollSpec { length, down, roll, lift, .. } = self.spec;
        let legs = [
            Leg { share: down, to: [z, 0.0] },
            Leg { share: roll, to: [z, length] },
            Leg { share: lift, to: [clear, length] },
        ];
        let controls = along(steps, [clear, 0.0], &legs).into_iter().map(|at| Control { poses: head(at) });
        Motion { start: head([clear, 0.0]), controls: controls.collect() }
    }
}
