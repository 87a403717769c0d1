//! The list of particle pairs that substep laws run over (Verlet 1967): drawn with a skin, so that it stays good for a while.
use crate::graph::{CellList, EDGE_KINDS, EdgeSet, Graph};
use crate::model::law::pair::PARTICLE;
use glam::DVec3;
use std::sync::Arc;

/// Width of the skin as a fraction of the reach: rebuilding is as cheap as a few substeps, so it is thin.
const SKIN: f64 = 0.1;

/// A half list of all pairs within reach, true until a particle has moved by half the skin.
pub(super) struct Neighbours {
    reach: f64,
    drawn_at: Vec<DVec3>,
    graph: Arc<Graph>,
}

impl Neighbours {
    /// The pairs within `reach` \[m\]; none are looked for when it is zero.
    pub(super) fn new(reach: f64, positions: &[DVec3]) -> Self {
        let mut edges = vec![EdgeSet { offsets: vec![0; positions.len() + 1], senders: Vec::new() }; EDGE_KINDS.len()];
        if reach > 0.0 {
            edges[PARTICLE] = half_list(positions, reach * (1.0 + SKIN));
        }
        Self { reach, drawn_at: positions.to_vec(), graph: Arc::new(Graph { edges, ..Graph::default() }) }
    }

    /// The list for `positions`, drawn again if it is no longer complete.
    pub(super) fn at(&mut self, positions: &[DVec3]) -> &Arc<Graph> {
        let limit = (0.5 * SKIN * self.reach).powi(2);
        let moved = |(now, then): (&DVec3, &DVec3)| now.distance_squared(*then) > limit;
        if self.reach > 0.0 && positions.iter().zip(&self.drawn_at).any(moved) {
            *self = Self::new(self.reach, positions);
        }
        &self.graph
    }
}

/// Each pair closer than `radius` once, in the row of its smaller index, by the larger.
fn half_list(positions: &[DVec3], radius: f64) -> EdgeSet {
    let cells = CellList::new(positions, radius);
    let mut set = EdgeSet { offsets: vec![0], senders: Vec::new() };
    for (i, at) in positions.iter().enumerate() {
        let first = set.senders.len();
        cells.near(*at, |j| {
            if j > i && positions[j].distance_squared(*at) < radius * radius {
                set.senders.push(j as u32);
            }
        });
        set.senders[first..].sort_unstable();
        set.offsets.push(set.senders.len() as u32);
    }
    set
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn every_pair_within_reach_is_listed_while_particles_drift() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut positions: Vec<DVec3> = (0..80).map(|_| DVec3::from_array(rng.random::<[f64; 3]>())).collect();
        let drift: Vec<DVec3> = (0..80).map(|_| DVec3::from_array(rng.random::<[f64; 3]>()) - 0.5).collect();
        let reach = 0.3;
        let mut neighbours = Neighbours::new(reach, &positions);
        for _ in 0..50 {
            let list = &neighbours.at(&positions).edges[PARTICLE];
            let mut listed: Vec<_> =
                list.pairs().filter(|&(i, j)| positions[i].distance(positions[j]) < reach).collect();
            listed.sort_unstable();
            let all = (0..80).flat_map(|i| (i + 1..80).map(move |j| (i, j)));
            let near: Vec<_> = all.filter(|&(i, j)| positions[i].distance(positions[j]) < reach).collect();
            assert_eq!(listed, near);
            positions.iter_mut().zip(&drift).for_each(|(x, d)| *x += 0.01 * *d);
        }
    }
}
