//! Which constraints positions violate.
use super::ProjectedSpec;
use super::constraint::Constraint;
use crate::graph::CellList;
use crate::model::law::View;
use crate::model::law::tool::Touch;
use crate::model::placed::Placed;
use crate::state::Wall;
use glam::DVec3;
use std::collections::BTreeSet;

/// By how much of a diameter a constraint may be violated without being felt: above the solver's accuracy.
const SLACK: f64 = 1e-6;

/// The constraints of one control step, each given out once.
pub(super) struct Allowed<'a> {
    spec: &'a ProjectedSpec,
    predicted: &'a [DVec3],
    planes: Vec<Wall>,
    touches: Vec<Touch<'a>>,
    /// Pairs that hold together, with the most that they may part and its slope.
    bonds: Vec<([usize; 2], f64, DVec3)>,
    given: BTreeSet<(usize, usize, usize)>,
}

impl<'a> Allowed<'a> {
    /// The tool's parts, for particles that constraints could take to them.
    pub(super) fn parts(spec: &ProjectedSpec, before: &View<'a>) -> Vec<Placed<'a>> {
        Placed::all(before, spec.clearance + spec.limit)
    }

    /// Of predicted positions, which followed from the start `before`, and the tool's parts.
    pub(super) fn new(
        spec: &'a ProjectedSpec,
        before: &View<'_>,
        predicted: &'a [DVec3],
        parts: &'a [Placed<'a>],
    ) -> Self {
        let mut touches = Vec::new();
        Placed::touches(parts, predicted, |touch| touches.push(touch));
        let start = &before.particles.positions;
        let mut bonds = Vec::new();
        pairs(start, spec.bond, |pair @ [i, j]| {
            let offset = start[i] - start[j];
            let (length, scale) = (offset.length(), 1.0 + spec.stretch);
            let free = length > spec.diameter;
            let slope = if free { scale * offset / length } else { DVec3::ZERO };
            bonds.push((pair, scale * length.max(spec.diameter), slope));
        });
        let planes = before.walls.iter().copied().chain([Wall::FLOOR]).collect();
        Self { spec, predicted, planes, touches, bonds, given: BTreeSet::new() }
    }

    /// The constraints that `positions` violate and that have not been given out.
    pub(super) fn violated(&mut self, positions: &[DVec3]) -> Vec<Constraint<'a>> {
        let Self { spec, predicted, planes, touches, bonds, given } = self;
        let slack = SLACK * spec.diameter;
        let mut found = Vec::new();
        for (k, plane) in planes.iter().enumerate() {
            for (particle, x) in positions.iter().enumerate() {
                let bound = plane.offset + spec.clearance;
                if plane.normal.dot(*x) < bound - slack && given.insert((0, k, particle)) {
                    found.push(Constraint::Front { particle, normal: plane.normal, bound, touch: None });
                }
            }
        }
        for (k, touch) in touches.iter().enumerate() {
            let (particle, normal) = (touch.particle, touch.normal());
            let bound = spec.clearance - touch.distance() + normal.dot(predicted[particle]);
            if normal.dot(positions[particle]) < bound - slack && given.insert((1, k, 0)) {
                found.push(Constraint::Front { particle, normal, bound, touch: Some(touch.clone()) });
            }
        }
        pairs(positions, spec.diameter - slack, |pair @ [i, j]| {
            let normal = (predicted[i] - predicted[j]).normalize_or_zero();
            // Two particles in one place have no direction to part in.
            if normal != DVec3::ZERO && given.insert((2, i, j)) {
                found.push(Constraint::Apart { pair, normal, least: spec.diameter });
            }
        });
        for &(pair @ [i, j], most, slope) in bonds.iter() {
            if positions[i].distance(positions[j]) > most + slack && given.insert((3, i, j)) {
                found.push(Constraint::Within { pair, most, slope });
            }
        }
        found
    }
}

/// Every pair i < j nearer than `radius` \[m\], in order.
fn pairs(positions: &[DVec3], radius: f64, mut visit: impl FnMut([usize; 2])) {
    if radius <= 0.0 || !positions.iter().all(|x| x.is_finite()) {
        return;
    }
    let near = CellList::new(positions, radius).neighbours(positions, radius);
    near.pairs().filter(|(i, j)| i < j).for_each(|(i, j)| visit([i, j]));
}
