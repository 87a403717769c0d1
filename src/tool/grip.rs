//! Two fingers that close on the material and open again.
use super::leg::{Leg, along};
use super::{HeadSpec, Motion, Tool, Workpiece};
use crate::state::{ActionSpace, Control, Pose, ToolShape};
use anyhow::ensure;
use glam::{DQuat, DVec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;
use std::sync::Arc;

/// A gripper: θ = (r, rotation, width), as RoboCook (Shi et al. 2023) parametrises it.
///
/// The fingers close along u = (cos rotation, sin rotation) on the point `centre + r (−sin rotation, cos rotation)` until
/// `width` is left between them. They start `max(opening, piece's half extent along u + clearance)` from that point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GripSpec {
    /// The finger on the side of −u; its face at local +x meets the material.
    pub finger: HeadSpec,
    /// The finger on the other side, turned to face the first; like it when left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub other: Option<HeadSpec>,
    /// Least distance of a finger's face from the grip point when open \[m\].
    #[schemars(range(min = 0.0, max = 0.5))]
    pub opening: f64,
    /// Distance kept to the workpiece's bounding box when open \[m\].
    #[schemars(range(min = 0.001, max = 0.1))]
    pub clearance: f64,
    /// Height of the fingers' lower ends above the table \[m\].
    #[schemars(range(min = 0.0005, max = 0.1))]
    pub height: f64,
    /// Bound of |rotation| \[rad\].
    #[schemars(range(min = 0.0, max = std::f64::consts::PI))]
    pub rotation: f64,
    /// Bounds of the final width \[m\]; the upper one gives way to the piece's smaller half extent.
    pub width: [f64; 2],
    /// Share of the steps in which the fingers close.
    #[schemars(range(min = 1, max = 100))]
    pub close: usize,
    /// Share of the steps in which they open.
    #[schemars(range(min = 1, max = 100))]
    pub open: usize,
}

/// See [`GripSpec`].
#[derive(Clone, Debug)]
pub struct Grip {
    spec: GripSpec,
    shape: Arc<ToolShape>,
    /// Half extents of each finger \[m\].
    half: [DVec3; 2],
}

impl GripSpec {
    /// The gripper.
    ///
    /// # Errors
    /// When a size is impossible.
    pub fn build(self) -> anyhow::Result<Grip> {
        let [low, high] = self.width;
        ensure!(0.0 < low && low <= high, "`width` needs 0 < least ≤ greatest, not {low} and {high}");
        ensure!(self.opening >= high / 2.0, "`opening` must be at least half of the greatest `width`, {}", high / 2.0);
        ensure!(self.clearance > 0.0, "`clearance` must be positive");
        ensure!(self.height > 0.0, "`height` must be positive, or the fingers scrape the table");
        ensure!(self.close > 0 && self.open > 0, "`close` and `open` need at least one step each");
        let finger = self.finger.clone().build()?;
        let other = self.other.clone().map_or_else(|| Ok(finger.clone()), HeadSpec::build)?;
        let half = [finger.solid.half_extents(), other.solid.half_extents()];
        Ok(Grip { shape: Arc::new(ToolShape::from(vec![finger, other])), half, spec: self })
    }
}

impl Tool for Grip {
    fn shape(&self) -> &Arc<ToolShape> {
        &self.shape
    }

    fn space(&self, piece: &Workpiece) -> ActionSpace {
        let (reach, [least, greatest]) = (piece.narrow(), self.spec.width);
        ActionSpace {
            names: ["r", "rotation", "width"].map(String::from).to_vec(),
            low: vec![-reach, -self.spec.rotation, least],
            high: vec![reach, self.spec.rotation, reach.min(greatest).max(least)],
        }
    }

    fn motion(&self, theta: &[f64], piece: &Workpiece, steps: usize) -> Motion {
        let &[r, rotation, width] = theta else { panic!("a grip takes three numbers, not {theta:?}") };
        let (sine, cosine) = rotation.sin_cos();
        let (along_u, across) = (DVec3::new(cosine, sine, 0.0), DVec3::new(-sine, cosine, 0.0));
        let open = self.spec.opening.max(piece.reach(cosine, sine) + self.spec.clearance);
        let point = (piece.centre + r * across).with_z(self.spec.height);
        let fingers = |[gap]: [f64; 1]| {
            [(-1.0, rotation, self.half[0]), (1.0, rotation + PI, self.half[1])]
                .map(|(side, yaw, half)| Pose {
                    translation: point + half.z * DVec3::Z + side * (gap + half.x) * along_u,
                    rotation: DQuat::from_rotation_z(yaw),
                })
                .to_vec()
        };
        let legs = [Leg { share: self.spec.close, to: [width / 2.0] }, Leg { share: self.spec.open, to: [open] }];
        let controls = along(steps, [open], &legs).into_iter().map(|gap| Control { poses: fingers(gap) });
        Motion { start: fingers([open]), controls: controls.collect() }
    }
}
