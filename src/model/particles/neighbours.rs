//! Lists of the particle pairs that substep laws run over (Verlet 1967): drawn with a skin, so that they stay good for a while.
use crate::graph::{CellList, EDGE_KINDS, EdgeSet, Graph};
use crate::model::law::pair::PARTICLE;
use glam::DVec3;
use std::sync::Arc;

/// Width of the skin as a fraction of the shortest reach: drawing lists costs no more than a few substeps, so it is thin.
const SKIN: f64 = 0.1;

/// For each of a few reaches, a half list of all pairs within it; true until a particle has moved by half the skin.
pub(super) struct Neighbours {
    reaches: Vec<f64>,
    skin: f64,
    drawn_at: Vec<DVec3>,
    lists: Arc<Lists>,
}

/// Half lists by reach: each pair once, in the row of its smaller index, by the larger.
pub(super) struct Lists(Vec<(f64, Graph)>);

impl Lists {
    /// The list drawn for `reach`.
    pub(super) fn of(&self, reach: f64) -> &Graph {
        let found = self.0.iter().find(|(r, _)| *r == reach);
        &found.expect("a list is drawn for the reach of every law").1
    }
}

impl Neighbours {
    /// The pairs within each of `reaches` \[m\]; none are looked for where it is zero.
    pub(super) fn new(mut reaches: Vec<f64>, positions: &[DVec3]) -> Self {
        reaches.sort_by(|a, b| b.total_cmp(a));
        reaches.dedup();
        let skin = SKIN * reaches.iter().copied().filter(|r| *r > 0.0).fold(f64::INFINITY, f64::min);
        let lists = Arc::new(draw(&reaches, skin, positions));
        Self { reaches, skin, drawn_at: positions.to_vec(), lists }
    }

    /// The lists for `positions`, drawn again if they are no longer complete.
    pub(super) fn at(&mut self, positions: &[DVec3]) -> &Arc<Lists> {
        let limit = (0.5 * self.skin).powi(2);
        let moved = |(now, then): (&DVec3, &DVec3)| now.distance_squared(*then) > limit;
        if self.skin.is_finite() && positions.iter().zip(&self.drawn_at).any(moved) {
            self.drawn_at.copy_from_slice(positions);
            self.lists = Arc::new(draw(&self.reaches, self.skin, positions));
        }
        &self.lists
    }
}

/// Lists for descending reaches, each drawn from the one before.
fn draw(reaches: &[f64], skin: f64, positions: &[DVec3]) -> Lists {
    let mut lists: Vec<(f64, Graph)> = Vec::with_capacity(reaches.len());
    for &reach in reaches {
        let mut edges = vec![EdgeSet { offsets: vec![0; positions.len() + 1], senders: Vec::new() }; EDGE_KINDS.len()];
        if reach > 0.0 {
            let wider = lists.last().map(|(_, graph)| &graph.edges[PARTICLE]);
            edges[PARTICLE] = match wider {
                Some(wider) => wider.only(|i, j| positions[i].distance_squared(positions[j]) < (reach + skin).powi(2)),
                None => CellList::new(positions, reach + skin).neighbours(positions, reach + skin).only(|i, j| i < j),
            };
        }
        lists.push((reach, Graph { edges, ..Graph::default() }));
    }
    Lists(lists)
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
        let mut neighbours = Neighbours::new(vec![0.2, 0.0, 0.3], &positions);
        for _ in 0..50 {
            let lists = neighbours.at(&positions);
            let all: Vec<_> = (0..80).flat_map(|i| (i + 1..80).map(move |j| (i, j))).collect();
            for reach in [0.0, 0.2, 0.3] {
                let within = |&(i, j): &(usize, usize)| positions[i].distance(positions[j]) < reach;
                let listed: Vec<_> = lists.of(reach).edges[PARTICLE].pairs().filter(within).collect();
                let near: Vec<_> = all.iter().copied().filter(within).collect();
                assert_eq!(listed, near);
            }
            positions.iter_mut().zip(&drift).for_each(|(x, d)| *x += 0.01 * *d);
        }
    }
}
