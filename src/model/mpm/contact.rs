//! What tool, table and walls do to the velocity of a node.
use crate::model::placed::Placed;
use crate::state::{PoseGrad, Twist, Wall};
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How a surface holds what touches it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum SurfaceSpec {
    /// What touches it moves with it, and does not come off.
    Sticky {},
    /// What touches it slides under Coulomb's friction, and comes off freely.
    Coulomb {
        /// Coefficient of friction μ \[1\].
        #[schemars(range(min = 0.0))]
        friction: f64,
    },
}

/// A velocity relative to a surface with normal n, after the surface has acted: with `v_n = v·n < 0` and `v_t = v − v_n n` the
/// normal part goes and `v_t ← v_t (1 − μ |v_n| / |v_t|)₊`.
#[inline]
fn held(surface: &SurfaceSpec, normal: DVec3, v: DVec3) -> DVec3 {
    let SurfaceSpec::Coulomb { friction } = surface else { return DVec3::ZERO };
    let along = v.dot(normal);
    if along >= 0.0 {
        return v;
    }
    let sliding = v - along * normal;
    let (speed, grip) = (sliding.length(), -friction * along);
    if grip == 0.0 {
        sliding
    } else if speed <= grip {
        DVec3::ZERO
    } else {
        sliding * (1.0 - grip / speed)
    }
}

/// `(∂J/∂v, ∂J/∂n)` from `∂J/∂held`.
#[inline]
fn held_vjp(surface: &SurfaceSpec, normal: DVec3, v: DVec3, at: DVec3) -> (DVec3, DVec3) {
    let SurfaceSpec::Coulomb { friction } = surface else { return (DVec3::ZERO, DVec3::ZERO) };
    let along = v.dot(normal);
    if along >= 0.0 {
        return (at, DVec3::ZERO);
    }
    let sliding = v - along * normal;
    let (speed, grip) = (sliding.length(), -friction * along);
    let (by_sliding, by_along) = if grip == 0.0 {
        (at, 0.0)
    } else if speed <= grip {
        return (DVec3::ZERO, DVec3::ZERO);
    } else {
        let direction = sliding / speed;
        let work = direction.dot(at);
        (at - grip / speed * (at - work * direction), friction * work)
    };
    let by_along = by_along - by_sliding.dot(normal);
    (by_sliding + by_along * normal, by_along * v - along * by_sliding)
}

/// Everything that nodes may meet in one substep.
pub(super) struct Contacts<'a> {
    pub(super) parts: Vec<Placed<'a>>,
    pub(super) tool: &'a SurfaceSpec,
    /// Distance ℓ over which a part's hold fades \[m\].
    pub(super) softness: f64,
    pub(super) walls: &'a [Wall],
    pub(super) table: &'a SurfaceSpec,
}

/// `∂J/∂(pose, twist)` of every part.
pub(super) struct PartsGrad {
    pub(super) poses: Vec<PoseGrad>,
    pub(super) twists: Vec<Twist>,
}

impl Contacts<'_> {
    /// Softnesses within which a part holds.
    pub(super) const REACH: f64 = 7.0;

    /// The velocity that a node at `place` keeps \[m/s\].
    ///
    /// A part whose surface moves at `v_c`, d away, has the share s of it, `v ← v_c + (1 − s) (v − v_c) + s held(v − v_c)` with
    /// `s = min(e^{−d/ℓ}, 1)` (Huang et al. 2021), here shifted by `e⁻⁷` so that it ends at 7 ℓ without a jump; table and walls
    /// have all of what is on or behind them.
    #[inline]
    pub(super) fn act(&self, place: DVec3, mut v: DVec3) -> DVec3 {
        for part in &self.parts {
            v = self.touched(part, place, v);
        }
        for plane in self.planes().filter(|plane| behind(plane, place)) {
            v = held(self.table, plane.normal, v);
        }
        v
    }

    fn planes(&self) -> impl Iterator<Item = &Wall> {
        std::iter::once(&Wall::FLOOR).chain(self.walls)
    }

    /// s and ∂s/∂d at a distance of a part nearer than its reach.
    #[inline]
    fn share(&self, distance: f64) -> (f64, f64) {
        if distance <= 0.0 {
            return (1.0, 0.0);
        }
        let (fade, end) = ((-distance / self.softness).exp(), (-Self::REACH).exp());
        ((fade - end) / (1.0 - end), -fade / ((1.0 - end) * self.softness))
    }

    #[inline]
    fn touched(&self, part: &Placed<'_>, place: DVec3, v: DVec3) -> DVec3 {
        let Some((arm, field)) = part.field(place).filter(|(_, field)| field.distance < part.reach) else { return v };
        let carried = part.twist.linear + part.twist.angular.cross(arm);
        let relative = v - carried;
        let (share, _) = self.share(field.distance);
        v + share * (held(self.tool, part.rotation * field.normal, relative) - relative)
    }

    /// `∂J/∂v` from `∂J/∂act(v)`; adds what is the parts' to `grad`.
    pub(super) fn pull(&self, place: DVec3, v: DVec3, at: DVec3, grad: &mut PartsGrad) -> DVec3 {
        self.pull_from(0, place, v, at, grad)
    }

    /// [`Contacts::pull`] through the parts from number `first` on.
    fn pull_from(&self, first: usize, place: DVec3, v: DVec3, at: DVec3, grad: &mut PartsGrad) -> DVec3 {
        let Some(part) = self.parts.get(first) else { return self.pull_planes(0, place, v, at) };
        let near = part.field(place).filter(|(_, field)| field.distance < part.reach);
        let Some((arm, field)) = near else { return self.pull_from(first + 1, place, v, at, grad) };
        let next = self.touched(part, place, v);
        let at = self.pull_from(first + 1, place, next, at, grad);
        let carried = part.twist.linear + part.twist.angular.cross(arm);
        let (relative, normal) = (v - carried, part.rotation * field.normal);
        let (share, slope) = self.share(field.distance);
        let kept = held(self.tool, normal, relative);
        let (by_relative, by_normal) = held_vjp(self.tool, normal, relative, share * at);
        let back = at - share * at + by_relative;
        let by_carried = at - back;
        let by_distance = slope * at.dot(kept - relative);
        // How the field under the node changes as the part moves, as in the law of the tool.
        let bend = part.rotation * (field.curvature * (part.inverse * by_normal));
        let by_field = by_distance * normal + bend;
        let (pose, twist) = (&mut grad.poses[first], &mut grad.twists[first]);
        pose.translation -= by_field + by_carried.cross(part.twist.angular);
        pose.rotation += normal.cross(by_normal) - arm.cross(by_field);
        twist.linear += by_carried;
        twist.angular += arm.cross(by_carried);
        back
    }

    /// [`Contacts::pull`] through the planes from number `first` on.
    fn pull_planes(&self, first: usize, place: DVec3, v: DVec3, at: DVec3) -> DVec3 {
        let Some(plane) = self.planes().nth(first) else { return at };
        if !behind(plane, place) {
            return self.pull_planes(first + 1, place, v, at);
        }
        let at = self.pull_planes(first + 1, place, held(self.table, plane.normal, v), at);
        held_vjp(self.table, plane.normal, v, at).0
    }
}

/// Nodes on a plane are behind it, whatever rounding says.
#[inline]
fn behind(plane: &Wall, place: DVec3) -> bool {
    plane.distance(place) <= 1e-12
}
