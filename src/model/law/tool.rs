//! The tool: compliant contact with moving rigid parts through their signed distance.
use super::compliant::CompliantSpec;
use super::{Law, View, ViewGrad};
use crate::state::{Pose, Projection, Solid, Twist};
use glam::{DMat3, DVec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Config of [`Tool`]: a particle sinks into a part by `δ = R − d(x)`, d the part's signed distance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct ToolSpec(pub CompliantSpec);

impl ToolSpec {
    pub(crate) fn build(self) -> anyhow::Result<Tool> {
        self.0.check("tool")?;
        Ok(Tool(self.0))
    }
}

/// The compliant contact of every particle with every part of the tool, sliding relative to the part's moving surface.
pub struct Tool(CompliantSpec);

/// One part at one instant, with its rotation as matrices and its extents at hand.
struct Placed<'a> {
    solid: &'a Solid,
    centre: DVec3,
    rotation: DMat3,
    inverse: DMat3,
    twist: Twist,
    extents: DVec3,
    ball: f64,
}

impl<'a> Placed<'a> {
    fn new(solid: &'a Solid, pose: &Pose, twist: &Twist, radius: f64) -> Self {
        let rotation = DMat3::from_quat(pose.rotation);
        let extents = solid.half_extents() + radius;
        Self {
            solid,
            centre: pose.translation,
            rotation,
            inverse: rotation.transpose(),
            twist: *twist,
            extents,
            ball: extents.length_squared(),
        }
    }

    /// The arm from the part's origin and the field there, or `None` where the part is surely out of reach.
    #[inline]
    fn field(&self, position: DVec3) -> Option<(DVec3, Projection)> {
        let arm = position - self.centre;
        if arm.length_squared() >= self.ball {
            return None;
        }
        let local = self.inverse * arm;
        local.abs().cmplt(self.extents).all().then(|| (arm, self.solid.project(local)))
    }
}

impl Tool {
    /// Calls `visit` with every particle that overlaps a part: (part, its place, particle, arm, overlap, field).
    #[inline]
    fn visit(&self, view: &View<'_>, mut visit: impl FnMut(usize, &Placed<'_>, usize, DVec3, f64, &Projection)) {
        for (k, ((part, pose), twist)) in view.tool.parts.iter().zip(view.poses).zip(view.twists).enumerate() {
            let placed = Placed::new(&part.solid, pose, twist, self.0.radius);
            for (i, position) in view.particles.positions.iter().enumerate() {
                if let Some((arm, field)) = placed.field(*position)
                    && field.distance < self.0.radius
                {
                    visit(k, &placed, i, arm, self.0.radius - field.distance, &field);
                }
            }
        }
    }
}

impl Law for Tool {
    fn accelerate(&self, view: &View<'_>, out: &mut [DVec3]) {
        self.visit(view, |_, part, i, arm, overlap, field| {
            let surface = part.twist.linear + part.twist.angular.cross(arm);
            let velocity = view.particles.velocities[i] - surface;
            out[i] += self.0.acceleration(overlap, part.rotation * field.normal, velocity);
        });
    }

    /// With arm a = x − t and world field gradient `f = −(∂J/∂δ) n + H ∂J/∂n`: a rotation δr of the part moves the field under
    /// the particle by `−δr × a` and turns n by `δr × n`.
    fn accelerate_vjp(&self, view: &View<'_>, out: &[DVec3], grad: &mut ViewGrad<'_>) {
        self.visit(view, |k, part, i, arm, overlap, field| {
            let surface = part.twist.linear + part.twist.angular.cross(arm);
            let velocity = view.particles.velocities[i] - surface;
            let normal = part.rotation * field.normal;
            let by = self.0.pull(overlap, normal, velocity, out[i]);
            let bend = part.rotation * (field.curvature * (part.inverse * by.normal));
            let by_field = bend - by.overlap * normal;
            let by_arm = by_field + part.twist.angular.cross(by.velocity);
            grad.particles.positions[i] += by_arm;
            grad.particles.velocities[i] += by.velocity;
            grad.poses[k].translation -= by_arm;
            grad.poses[k].rotation += normal.cross(by.normal) - arm.cross(by_field);
            grad.twists[k].linear -= by.velocity;
            grad.twists[k].angular -= arm.cross(by.velocity);
        });
    }
}
