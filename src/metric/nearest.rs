//! The nearest point of one cloud to every point of another, by brute force.
use glam::DVec3;

/// Queries searched at once: one register of squared distances on the machines this is built for, twice over.
const LANES: usize = 8;

/// The nearest neighbour of one query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Nearest {
    /// Its row; the lowest of those equally near.
    pub(super) row: usize,
    /// Euclidean distance to it \[m\].
    pub(super) distance: f64,
}

/// The nearest of `points` to each of `queries`: O(N·M), without branches, in one pass over `points` per eight queries.
pub(super) fn nearest(queries: &[DVec3], points: &[DVec3]) -> Vec<Nearest> {
    let mut out = Vec::with_capacity(queries.len());
    for block in queries.chunks(LANES) {
        let query = |axis: usize| -> [f64; LANES] { std::array::from_fn(|l| block[l.min(block.len() - 1)][axis]) };
        let (x, y, z) = (query(0), query(1), query(2));
        let mut least = [f64::INFINITY; LANES];
        // Rows are carried as f64 so that both selections have one width; rows below 2⁵³ are exact.
        let mut row = [0.0; LANES];
        for (j, point) in points.iter().enumerate() {
            let j = j as f64;
            for l in 0..LANES {
                let (dx, dy, dz) = (x[l] - point.x, y[l] - point.y, z[l] - point.z);
                let squared = dx * dx + dy * dy + dz * dz;
                let nearer = squared < least[l];
                least[l] = if nearer { squared } else { least[l] };
                row[l] = if nearer { j } else { row[l] };
            }
        }
        out.extend((0..block.len()).map(|l| Nearest { row: row[l] as usize, distance: least[l].sqrt() }));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metric::tests::cloud;

    #[test]
    fn it_agrees_with_the_naive_search_for_every_length_of_the_last_block() {
        let points = cloud(37, 1);
        for count in 0..=17 {
            let queries = cloud(count, 2);
            let naive: Vec<Nearest> = queries
                .iter()
                .map(|q| {
                    let key = |p: &DVec3| q.distance(*p);
                    let row = (0..points.len()).min_by(|&a, &b| key(&points[a]).total_cmp(&key(&points[b]))).unwrap();
                    Nearest { row, distance: key(&points[row]) }
                })
                .collect();
            let found = nearest(&queries, &points);
            assert_eq!(found.len(), count);
            for (a, b) in found.iter().zip(&naive) {
                assert!(a.row == b.row && (a.distance - b.distance).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn ties_go_to_the_lowest_row() {
        let points = [DVec3::X, DVec3::NEG_X, DVec3::X];
        assert_eq!(nearest(&[DVec3::ZERO], &points), [Nearest { row: 0, distance: 1.0 }]);
    }
}
