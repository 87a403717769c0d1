//! Who meets whom within reach of a learned pair law, and the invariants of each meeting.
use super::LearnedPair;
use crate::model::law::View;
use crate::model::law::pair::PARTICLE;
use crate::model::law::tool::Touch;
use crate::model::placed::Placed;
use crate::state::Wall;
use glam::DVec3;

/// Who meets whom.
pub(super) enum Ends<'a> {
    Pair(usize, usize),
    Touch(Box<Touch<'a>>),
    Plane(usize, DVec3),
}

/// One meeting, and its invariants.
pub(super) struct Meeting<'a> {
    pub(super) ends: Ends<'a>,
    pub(super) distance: f64,
    pub(super) normal: DVec3,
    pub(super) velocity: DVec3,
    pub(super) separating: f64,
    pub(super) sliding: DVec3,
}

impl<'a> Meeting<'a> {
    fn new(ends: Ends<'a>, distance: f64, normal: DVec3, velocity: DVec3) -> Self {
        let separating = velocity.dot(normal);
        Self { ends, distance, normal, velocity, separating, sliding: velocity - separating * normal }
    }
}

impl LearnedPair {
    /// All meetings of one kind, in a fixed order.
    pub(super) fn meetings<'a>(&self, kind: usize, view: &View<'a>, parts: &'a [Placed<'a>]) -> Vec<Meeting<'a>> {
        let (positions, velocities) = (&view.particles.positions[..], &view.particles.velocities[..]);
        let reach = self.reach_of(kind);
        let mut found = Vec::new();
        match kind {
            PARTICLE => {
                for (i, j) in view.graph.edges[PARTICLE].pairs() {
                    let offset = positions[i] - positions[j];
                    let distance = offset.length();
                    // Two particles in one place have no direction to push in.
                    if distance < reach && distance > 0.0 {
                        let velocity = velocities[i] - velocities[j];
                        found.push(Meeting::new(Ends::Pair(i, j), distance, offset / distance, velocity));
                    }
                }
            }
            1 => Placed::touches(parts, positions, |touch| {
                let (distance, normal, velocity) = (touch.distance(), touch.normal(), touch.velocity(view));
                found.push(Meeting::new(Ends::Touch(Box::new(touch)), distance, normal, velocity));
            }),
            _ => {
                for plane in std::iter::once(&Wall::FLOOR).chain(view.walls) {
                    for (i, (x, v)) in positions.iter().zip(velocities).enumerate() {
                        let distance = plane.distance(*x);
                        if distance < reach {
                            found.push(Meeting::new(Ends::Plane(i, plane.normal), distance, plane.normal, *v));
                        }
                    }
                }
            }
        }
        found
    }
}
