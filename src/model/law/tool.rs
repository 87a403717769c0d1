//! The tool: compliant contact with moving rigid parts through their signed distance.
use super::compliant::{CompliantSpec, ContactGrad};
use super::history::Remember;
use super::tangential;
use super::touching::{self, Meeting, MeetingGrad, Touching};
use super::{Law, View, ViewGrad};
use crate::model::placed::Placed;
use crate::state::Projection;
use glam::DVec3;
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

/// A particle within reach of a part.
#[derive(Clone)]
pub(in crate::model) struct Touch<'a> {
    part: usize,
    placed: &'a Placed<'a>,
    pub(in crate::model) particle: usize,
    /// From the part's origin to the particle.
    arm: DVec3,
    field: Projection,
}

impl<'a> Placed<'a> {
    /// Every part of a scene's tool, for particles nearer than `reach` \[m\].
    pub(in crate::model) fn all(view: &View<'a>, reach: f64) -> Vec<Self> {
        let parts = view.tool.parts.iter().zip(view.poses).zip(view.twists);
        parts.map(|((part, pose), twist)| Self::new(&part.solid, pose, twist, reach)).collect()
    }

    /// Calls `visit` with every particle that is nearer to a part than its reach, part by part.
    #[inline]
    pub(in crate::model) fn touches<'p>(
        parts: &'p [Placed<'a>],
        positions: &[DVec3],
        mut visit: impl FnMut(Touch<'p>),
    ) {
        for (part, placed) in parts.iter().enumerate() {
            for (particle, position) in positions.iter().enumerate() {
                if let Some((arm, field)) = placed.field(*position)
                    && field.distance < placed.reach
                {
                    visit(Touch { part, placed, particle, arm, field });
                }
            }
        }
    }
}

impl Touch<'_> {
    /// Signed distance from the part \[m\].
    pub(in crate::model) fn distance(&self) -> f64 {
        self.field.distance
    }

    /// The part's outward normal in the world.
    #[inline]
    pub(in crate::model) fn normal(&self) -> DVec3 {
        self.placed.rotation * self.field.normal
    }

    /// Velocity of the particle relative to the part's surface \[m/s\].
    #[inline]
    pub(in crate::model) fn velocity(&self, view: &View<'_>) -> DVec3 {
        let surface = self.placed.twist.linear + self.placed.twist.angular.cross(self.arm);
        view.particles.velocities[self.particle] - surface
    }

    /// Adds to `grad` what `by` is to particle and part.
    ///
    /// With arm a = x − t and world field gradient `f = −(∂J/∂δ) n + H ∂J/∂n`: a rotation δr of the part moves the field under
    /// the particle by `−δr × a` and turns n by `δr × n`.
    #[inline]
    pub(in crate::model) fn pull(&self, by: &ContactGrad, grad: &mut ViewGrad<'_>) {
        let (part, normal, arm) = (self.placed, self.normal(), self.arm);
        let bend = part.rotation * (self.field.curvature * (part.inverse * by.normal));
        let by_field = bend - by.overlap * normal;
        let by_arm = by_field + part.twist.angular.cross(by.velocity);
        grad.particles.positions[self.particle] += by_arm;
        grad.particles.velocities[self.particle] += by.velocity;
        grad.poses[self.part].translation -= by_arm;
        grad.poses[self.part].rotation += normal.cross(by.normal) - arm.cross(by_field);
        grad.twists[self.part].linear -= by.velocity;
        grad.twists[self.part].angular -= arm.cross(by.velocity);
    }
}

impl Law for Tool {
    fn remembers(&self) -> Option<&dyn Remember> {
        self.0.springs().then_some(self as &dyn Remember)
    }

    fn stable(&self) -> f64 {
        self.0.stable()
    }

    fn accelerate(&self, view: &View<'_>, out: &mut [DVec3]) {
        if self.0.springs() {
            return touching::accelerate(self, view, out);
        }
        let (law, parts) = (&self.0, Placed::all(view, self.0.radius));
        Placed::touches(&parts, &view.particles.positions, |touch| {
            let overlap = law.radius - touch.distance();
            out[touch.particle] += law.acceleration(overlap, touch.normal(), touch.velocity(view));
        });
    }

    fn accelerate_vjp(&self, view: &View<'_>, out: &[DVec3], grad: &mut ViewGrad<'_>) {
        if self.0.springs() {
            return touching::accelerate_vjp(self, view, out, grad);
        }
        let (law, parts) = (&self.0, Placed::all(view, self.0.radius));
        Placed::touches(&parts, &view.particles.positions, |touch| {
            let overlap = law.radius - touch.distance();
            let by = law.pull(overlap, touch.normal(), touch.velocity(view), out[touch.particle]);
            touch.pull(&by, grad);
        });
    }

    fn constants(&self) -> Vec<&str> {
        self.0.constants().to_vec()
    }

    fn constants_vjp(&self, view: &View<'_>, out: &[DVec3], constants: &mut [f64]) {
        if self.0.springs() {
            return touching::constants_vjp(self, view, out, constants);
        }
        let (law, parts) = (&self.0, Placed::all(view, self.0.radius));
        Placed::touches(&parts, &view.particles.positions, |touch| {
            let overlap = law.radius - touch.distance();
            let by = law.pull_constants(overlap, touch.normal(), touch.velocity(view), out[touch.particle]);
            constants.iter_mut().zip(by).for_each(|(sum, by)| *sum += by);
        });
    }
}

impl Tool {
    /// What the law sees of a touch: its spring is kept in the part's own axes.
    fn meeting(&self, touch: &Touch<'_>, view: &View<'_>) -> Meeting {
        let (overlap, normal, velocity) = (self.0.radius - touch.distance(), touch.normal(), touch.velocity(view));
        Meeting {
            pair: [touch.part as u32, touch.particle as u32],
            pushed: touch.particle,
            opposite: None,
            touch: tangential::Touch { overlap, normal, velocity },
            frame: touch.placed.rotation,
        }
    }
}

impl Touching for Tool {
    const RADII: f64 = 1.0;

    fn spec(&self) -> &CompliantSpec {
        &self.0
    }

    fn meet(&self, view: &View<'_>, visit: &mut dyn FnMut(&Meeting)) {
        let parts = Placed::all(view, self.0.radius);
        Placed::touches(&parts, &view.particles.positions, |touch| visit(&self.meeting(&touch, view)));
    }

    fn pull(&self, view: &View<'_>, grad: &mut ViewGrad<'_>, visit: &mut dyn FnMut(&Meeting) -> MeetingGrad) {
        let parts = Placed::all(view, self.0.radius);
        Placed::touches(&parts, &view.particles.positions, |touch| {
            let by = visit(&self.meeting(&touch, view));
            touch.pull(&by.contact, grad);
            grad.poses[touch.part].rotation += by.turn;
        });
    }
}
