//! How the picture shows a tool: at every cell and level how near it is at the step's end, and how far it came.
use super::GridSpec;
use crate::model::placed::Placed;
use crate::state::{Pose, PoseGrad, ToolShape, Twist};
use glam::DVec3;

/// Numbers a level: the nearness, and nearness times displacement.
pub(super) const NUMBERS: usize = 4;

/// `Σ_p w(d_p)` and `Σ_p w(d_p) u_p / scale` over the parts p, where d is the signed distance of cell c from a part at the end of the step,
/// `u_p = T (linear_p + angular_p × (c − t_p))` how its material there moves, and `w(d) = (1 − s)² (1 + 2 s)` with `s = d/reach` in \[0, 1\]: one inside, none beyond the reach.
pub(super) struct ToolView<'a> {
    pub(super) grid: &'a GridSpec,
    pub(super) tool: &'a ToolShape,
    /// Poses at the end of the step.
    pub(super) poses: &'a [Pose],
    pub(super) twists: &'a [Twist],
    /// Duration of the step \[s\].
    pub(super) interval: f64,
    /// Distance at which a part is no longer seen \[m\].
    pub(super) reach: f64,
    /// Displacement that counts as one \[m\].
    pub(super) scale: f64,
}

/// One part as seen from one point.
struct Sight {
    /// Place of the point's first number in the picture.
    place: usize,
    part: usize,
    /// From the part's origin to the point.
    arm: DVec3,
    nearness: f64,
    /// `∂w/∂x` of the point \[1/m\].
    slope: DVec3,
    /// u \[m\].
    motion: DVec3,
}

impl ToolView<'_> {
    /// Calls `visit` with every part that is seen from some point; a picture's row has `stride` numbers, the tool's after the first.
    fn sights(&self, stride: usize, mut visit: impl FnMut(Sight)) {
        let parts = self.tool.parts.iter().zip(self.poses).zip(self.twists);
        for (part, ((shape, pose), twist)) in parts.enumerate() {
            let placed = Placed::new(&shape.solid, pose, twist, self.reach);
            let around = shape.solid.half_extents().length() + self.reach;
            for (cell, middle) in self.grid.around(pose.translation.truncate(), around) {
                for level in 0..self.grid.levels {
                    let Some((arm, field)) = placed.field(middle.extend(self.grid.level(level))) else { continue };
                    let s = (field.distance / self.reach).clamp(0.0, 1.0);
                    visit(Sight {
                        place: cell * stride + 1 + NUMBERS * level,
                        part,
                        arm,
                        nearness: (1.0 - s).powi(2) * (1.0 + 2.0 * s),
                        slope: -6.0 * s * (1.0 - s) / self.reach * (placed.rotation * field.normal),
                        motion: self.interval * (twist.linear + twist.angular.cross(arm)),
                    });
                }
            }
        }
    }

    /// Adds the tool's numbers to a picture.
    pub(super) fn draw(&self, picture: &mut [f32], stride: usize) {
        // A tool that is nowhere is near to no cell: what is not a number must be seen nevertheless.
        if !self.poses.iter().all(|pose| pose.translation.is_finite() && pose.rotation.is_finite()) {
            picture.fill(f32::NAN);
            return;
        }
        self.sights(stride, |sight| {
            let row = &mut picture[sight.place..][..NUMBERS];
            row[0] += sight.nearness as f32;
            let shown = (sight.nearness / self.scale * sight.motion).as_vec3().to_array();
            row[1..].iter_mut().zip(shown).for_each(|(x, u)| *x += u);
        });
    }

    /// Adds `∂J/∂(poses, twists)` from `∂J/∂picture`.
    ///
    /// With arm a = c − t and `f = ∂J/∂w ∂w/∂c`: a turn δr of the part moves the field under the point by `−δr × a`.
    pub(super) fn pull(&self, at: &[f32], stride: usize, poses: &mut [PoseGrad], twists: &mut [Twist]) {
        self.sights(stride, |sight| {
            let row = &at[sight.place..][..NUMBERS];
            let at_shown = glam::Vec3::from_slice(&row[1..]).as_dvec3() / self.scale;
            let at_nearness = f64::from(row[0]) + at_shown.dot(sight.motion);
            let at_velocity = self.interval * sight.nearness * at_shown;
            let (twist, arm) = (&self.twists[sight.part], sight.arm);
            let by_field = at_nearness * sight.slope;
            poses[sight.part].translation -= by_field + at_velocity.cross(twist.angular);
            poses[sight.part].rotation -= arm.cross(by_field);
            twists[sight.part].linear += at_velocity;
            twists[sight.part].angular += arm.cross(at_velocity);
        });
    }
}
