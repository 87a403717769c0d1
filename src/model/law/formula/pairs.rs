//! Formulas between two particles: equal and opposite, so linear momentum is kept to rounding.
use super::meeting::{Meetings, Row, Rows};
use super::programs::Programs;
use crate::model::formula::BLOCK;
use crate::model::law::pair::PARTICLE;
use crate::model::law::{Law, View, ViewGrad};
use glam::DVec3;

/// The law that sums formulas over the half list of neighbours, each unordered pair once, a block of pairs at a time.
pub(super) struct Pairs(pub(super) Programs);

/// Pairs within reach, as they wait for a block to fill.
struct Block {
    count: usize,
    /// The particles of each pair.
    first: [u32; BLOCK],
    second: [u32; BLOCK],
}

impl Pairs {
    /// Fills blocks with every pair within reach, in the order of the list, and gives each to `full`.
    ///
    /// A pair is written before it is known to be within reach and overwritten if it is not: that needs no branch.
    #[inline]
    fn blocks(&self, view: &View<'_>, meetings: &mut Meetings<'_>, mut full: impl FnMut(&Block, &mut Meetings<'_>)) {
        let (positions, velocities) = (&view.particles.positions[..], &view.particles.velocities[..]);
        let list = &view.graph.edges[PARTICLE];
        let (limit, moves) = (meetings.reach() * meetings.reach(), meetings.moves());
        let mut block = Block { count: 0, first: [0; BLOCK], second: [0; BLOCK] };
        for (i, at) in positions.iter().enumerate() {
            for &j in &list.senders[list.offsets[i] as usize..list.offsets[i + 1] as usize] {
                let offset = *at - positions[j as usize];
                let square = offset.length_squared();
                // The remainder is the count itself; it spares the bounds checks.
                let k = block.count % BLOCK;
                (block.first[k], block.second[k]) = (i as u32, j);
                meetings.distance[k] = square;
                meetings.normal.set(k, offset);
                if moves {
                    meetings.velocity.set(k, velocities[i] - velocities[j as usize]);
                }
                // Two particles in one place have no direction to push in.
                block.count += usize::from(square < limit && square > 0.0);
                if block.count == BLOCK {
                    normalise(&mut meetings.distance, &mut meetings.normal);
                    full(&block, meetings);
                    block.count = 0;
                }
            }
        }
        if block.count > 0 {
            normalise(&mut meetings.distance, &mut meetings.normal);
            full(&block, meetings);
        }
    }
}

/// Squares to distances and offsets to normals.
fn normalise(distance: &mut Row, Rows([x, y, z]): &mut Rows) {
    for k in 0..BLOCK {
        distance[k] = distance[k].sqrt();
        let inverse = 1.0 / distance[k];
        x[k] *= inverse;
        y[k] *= inverse;
        z[k] *= inverse;
    }
}

impl Block {
    #[inline]
    fn pairs(&self) -> impl Iterator<Item = (usize, usize, usize)> {
        (0..self.count.min(BLOCK)).map(|k| (k, self.first[k] as usize, self.second[k] as usize))
    }
}

impl Law for Pairs {
    fn reach(&self) -> f64 {
        self.0.reach
    }

    fn accelerate(&self, view: &View<'_>, out: &mut [DVec3]) {
        self.blocks(view, &mut Meetings::forward(&self.0), |block, meetings| {
            meetings.accelerate();
            for (k, i, j) in block.pairs() {
                let push = meetings.acceleration.get(k);
                out[i] += push;
                out[j] -= push;
            }
        });
    }

    fn accelerate_vjp(&self, view: &View<'_>, out: &[DVec3], grad: &mut ViewGrad<'_>) {
        let grad = &mut grad.particles;
        self.blocks(view, &mut Meetings::adjoint(&self.0), |block, meetings| {
            for (k, i, j) in block.pairs() {
                meetings.acceleration.set(k, out[i] - out[j]);
            }
            meetings.pull();
            meetings.by_offset();
            for (k, i, j) in block.pairs() {
                let x = meetings.by_normal.get(k);
                grad.positions[i] += x;
                grad.positions[j] -= x;
                if meetings.moves() {
                    let v = meetings.by_velocity.get(k);
                    grad.velocities[i] += v;
                    grad.velocities[j] -= v;
                }
            }
        });
    }

    fn constants(&self) -> Vec<&str> {
        self.0.constants()
    }

    fn constants_vjp(&self, view: &View<'_>, out: &[DVec3], constants: &mut [f64]) {
        self.blocks(view, &mut Meetings::constants(&self.0), |block, meetings| {
            for (k, i, j) in block.pairs() {
                meetings.acceleration.set(k, out[i] - out[j]);
            }
            meetings.pull_constants(block.count, constants);
        });
    }
}
