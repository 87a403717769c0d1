//! A board that slides over the table into the side of the material and back.
use super::head::Head;
use super::leg::{Leg, along};
use super::{HeadSpec, Motion, Tool, Workpiece, stroke};
use crate::state::{ActionSpace, Control, Pose, ToolShape};
use anyhow::ensure;
use glam::{DQuat, DVec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A pusher: θ = (r, rotation, depth).
///
/// The board moves along u = (cos rotation, sin rotation) through the point `centre + r (−sin rotation, cos rotation)`: from
/// `clearance` before the workpiece's bounding box to `depth` past that box's near side, and back.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PushSpec {
    /// The board; its face at local +x meets the material.
    pub head: HeadSpec,
    /// Height of the board's lower edge above the table \[m\].
    #[schemars(range(min = 0.0005, max = 0.1))]
    pub height: f64,
    /// Bound of |rotation| \[rad\].
    #[schemars(range(min = 0.0, max = std::f64::consts::PI))]
    pub rotation: f64,
    /// Bounds of the depth \[m\]; the upper one gives way to the piece's smaller width.
    pub depth: [f64; 2],
    /// Distance kept to the workpiece's bounding box at the start and at the end \[m\].
    #[schemars(range(min = 0.001, max = 0.1))]
    pub clearance: f64,
    /// Share of the steps in which the board pushes.
    #[schemars(range(min = 1, max = 100))]
    pub push: usize,
    /// Share of the steps in which it goes back.
    #[schemars(range(min = 1, max = 100))]
    pub back: usize,
}

/// See [`PushSpec`].
#[derive(Clone, Debug)]
pub struct Push {
    spec: PushSpec,
    head: Head,
}

impl PushSpec {
    /// The pusher.
    ///
    /// # Errors
    /// When a size is impossible.
    pub fn build(self) -> anyhow::Result<Push> {
        stroke::check(self.depth, self.clearance)?;
        ensure!(self.height > 0.0, "`height` must be positive, or the board scrapes the table");
        ensure!(self.push > 0 && self.back > 0, "`push` and `back` need at least one step each");
        Ok(Push { head: self.head.clone().alone()?, spec: self })
    }
}

impl Tool for Push {
    fn shape(&self) -> &Arc<ToolShape> {
        &self.head.shape
    }

    fn space(&self, piece: &Workpiece) -> ActionSpace {
        stroke::across(piece, self.spec.rotation, self.spec.depth)
    }

    fn motion(&self, theta: &[f64], piece: &Workpiece, steps: usize) -> Motion {
        let &[r, rotation, depth] = theta else { panic!("a push takes three numbers, not {theta:?}") };
        let (sine, cosine) = rotation.sin_cos();
        let before = -piece.reach(cosine, sine);
        let line = piece.centre + r * DVec3::new(-sine, cosine, 0.0);
        let board = |[face]: [f64; 1]| {
            let translation = line + (face - self.head.half.x) * DVec3::new(cosine, sine, 0.0);
            let translation = translation.with_z(self.spec.height + self.head.half.z);
            vec![Pose { translation, rotation: DQuat::from_rotation_z(rotation) }]
        };
        let clear = before - self.spec.clearance;
        let legs = [Leg { share: self.spec.push, to: [before + depth] }, Leg { share: self.spec.back, to: [clear] }];
        let controls = along(steps, [clear], &legs).into_iter().map(|face| Control { poses: board(face) });
        Motion { start: board([clear]), controls: controls.collect() }
    }
}
