//! Pairs of near points, by a grid of cells.
use glam::{DVec3, IVec3};

/// For each point the others within a radius, in a fixed order.
pub(super) struct Neighbours {
    starts: Vec<usize>,
    others: Vec<usize>,
}

impl Neighbours {
    /// Of all `points` closer than `radius` to each other.
    pub(super) fn within(points: &[DVec3], radius: f64) -> Self {
        let cell = |p: &DVec3| (*p / radius).floor().as_ivec3();
        let key = |c: IVec3| (c.x, c.y, c.z);
        let mut sorted: Vec<_> = points.iter().enumerate().map(|(i, p)| (key(cell(p)), i)).collect();
        sorted.sort_unstable();
        let (mut starts, mut others) = (vec![0], Vec::new());
        for (i, p) in points.iter().enumerate() {
            let middle = cell(p);
            for dx in -1..=1 {
                for dy in -1..=1 {
                    // Three cells along z stand in one run.
                    let (low, high) = (middle + IVec3::new(dx, dy, -1), middle + IVec3::new(dx, dy, 1));
                    let from = sorted.partition_point(|(k, _)| *k < key(low));
                    let run = sorted[from..].iter().take_while(|(k, _)| *k <= key(high)).map(|(_, j)| *j);
                    others.extend(run.filter(|&j| j != i && p.distance_squared(points[j]) < radius * radius));
                }
            }
            starts.push(others.len());
        }
        Self { starts, others }
    }

    /// The neighbours of point `i`.
    pub(super) fn of(&self, i: usize) -> &[usize] {
        &self.others[self.range(i)]
    }

    /// Where those of point `i` stand among all pairs.
    pub(super) fn range(&self, i: usize) -> std::ops::Range<usize> {
        self.starts[i]..self.starts[i + 1]
    }

    /// Number of pairs, each counted from both sides.
    pub(super) fn pairs(&self) -> usize {
        self.others.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn the_pairs_are_those_of_a_search_through_all() {
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        for radius in [0.05, 0.3, 1.4] {
            let points: Vec<DVec3> =
                (0..300).map(|_| DVec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0)))).collect();
            let neighbours = Neighbours::within(&points, radius);
            for (i, p) in points.iter().enumerate() {
                let mut found = neighbours.of(i).to_vec();
                found.sort_unstable();
                let all: Vec<usize> = (0..300).filter(|&j| j != i && p.distance(points[j]) < radius).collect();
                assert_eq!(found, all);
            }
        }
    }
}
