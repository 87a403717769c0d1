//! A flat head that comes down on the material and lifts again.
use super::head::Head;
use super::leg::{Leg, along};
use super::{HeadSpec, Motion, Tool, Workpiece, turn};
use crate::state::{ActionSpace, Control, Pose, ToolShape};
use anyhow::ensure;
use glam::{DQuat, DVec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A press: θ = (x, y, z, rotation), as RoboCook (Shi et al. 2023) parametrises it; (x, y, z) for a head that is not turned.
///
/// The head, turned by `rotation` about the vertical, comes down at `centre + (x, y)` until its face is at height `z`, at
/// most the workpiece's height.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PressSpec {
    /// The head; its face at local −z meets the material.
    pub head: HeadSpec,
    /// Bound of |x| and |y| \[m\].
    #[schemars(range(min = 0.0, max = 0.5))]
    pub reach: f64,
    /// Least final height of the face above the table \[m\].
    #[schemars(range(min = 0.0005, max = 0.1))]
    pub lowest: f64,
    /// Bound of |rotation| \[rad\]; with 0 the action has no rotation.
    #[schemars(range(min = 0.0, max = std::f64::consts::PI))]
    pub rotation: f64,
    /// Distance kept above the workpiece at the start and at the end \[m\].
    #[schemars(range(min = 0.001, max = 0.1))]
    pub clearance: f64,
    /// Share of the steps in which the head comes down.
    #[schemars(range(min = 1, max = 100))]
    pub down: usize,
    /// Share of the steps in which it lifts.
    #[schemars(range(min = 1, max = 100))]
    pub lift: usize,
}

/// See [`PressSpec`].
#[derive(Clone, Debug)]
pub struct Press {
    spec: PressSpec,
    head: Head,
}

impl PressSpec {
    /// The press.
    ///
    /// # Errors
    /// When a size is impossible.
    pub fn build(self) -> anyhow::Result<Press> {
        ensure!(self.lowest > 0.0, "`lowest` must be positive, or material is squeezed through the table");
        ensure!(self.clearance > 0.0, "`clearance` must be positive");
        ensure!(self.down > 0 && self.lift > 0, "`down` and `lift` need at least one step each");
        Ok(Press { head: self.head.clone().alone()?, spec: self })
    }
}

impl Tool for Press {
    fn shape(&self) -> &Arc<ToolShape> {
        &self.head.shape
    }

    fn space(&self, piece: &Workpiece) -> ActionSpace {
        let PressSpec { reach, rotation, lowest, .. } = self.spec;
        let mut space = ActionSpace {
            names: ["x", "y", "z"].map(String::from).to_vec(),
            low: vec![-reach, -reach, lowest],
            high: vec![reach, reach, piece.extent.z.max(lowest)],
        };
        turn::append(&mut space, rotation);
        space
    }

    fn motion(&self, theta: &[f64], piece: &Workpiece, steps: usize) -> Motion {
        let (&[x, y, z], rotation) = turn::take(theta, self.spec.rotation) else {
            panic!("a press takes three numbers, or four with a rotation, not {theta:?}")
        };
        let clear = piece.extent.z.max(self.spec.lowest) + self.spec.clearance;
        let head = |[face]: [f64; 1]| {
            let translation = piece.centre + DVec3::new(x, y, face + self.head.half.z);
            vec![Pose { translation, rotation: DQuat::from_rotation_z(rotation) }]
        };
        let legs = [Leg { share: self.spec.down, to: [z] }, Leg { share: self.spec.lift, to: [clear] }];
        let controls = along(steps, [clear], &legs).into_iter().map(|face| Control { poses: head(face) });
        Motion { start: head([clear]), controls: controls.collect() }
    }
}
