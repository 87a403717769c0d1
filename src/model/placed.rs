//! A part of the tool at one instant, and the field of its distance around it.
use crate::state::{Pose, Projection, Solid, Twist};
use glam::{DMat3, DVec3};

/// One part at one instant, with its rotation as matrices and its extents at hand.
pub(super) struct Placed<'a> {
    solid: &'a Solid,
    centre: DVec3,
    pub(super) rotation: DMat3,
    pub(super) inverse: DMat3,
    pub(super) twist: Twist,
    extents: DVec3,
    ball: f64,
    pub(super) reach: f64,
}

impl<'a> Placed<'a> {
    /// `solid` where `pose` has it, for points nearer than `reach` \[m\].
    pub(super) fn new(solid: &'a Solid, pose: &Pose, twist: &Twist, reach: f64) -> Self {
        let rotation = DMat3::from_quat(pose.rotation);
        let extents = solid.half_extents() + reach;
        Self {
            solid,
            centre: pose.translation,
            rotation,
            inverse: rotation.transpose(),
            twist: *twist,
            extents,
            ball: extents.length_squared(),
            reach,
        }
    }

    /// The arm from the part's origin and the field there, in the part's frame, or `None` where the part is surely out of reach.
    #[inline]
    pub(super) fn field(&self, position: DVec3) -> Option<(DVec3, Projection)> {
        let arm = position - self.centre;
        if arm.length_squared() >= self.ball {
            return None;
        }
        let local = self.inverse * arm;
        local.abs().cmplt(self.extents).all().then(|| (arm, self.solid.project(local)))
    }
}
