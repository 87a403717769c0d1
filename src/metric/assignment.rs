//! The optimal one-to-one assignment between two clouds.
use glam::DVec3;

/// The most points that are assigned to each other; larger clouds are thinned to it.
pub const EMD_LIMIT: usize = 512;

/// Which row of the goal each kept row of a cloud is carried to.
pub(super) struct Assignment {
    /// (row of the cloud, row of the goal); every kept row of both appears once.
    pub(super) pairs: Vec<(usize, usize)>,
    /// Mean distance of the pairs \[m\].
    pub(super) mean: f64,
}

/// The assignment of least mean distance (Crouse 2016, shortest augmenting paths), exact between the kept rows.
///
/// Both clouds are thinned to the smaller of their sizes and [`EMD_LIMIT`]. `None` when one is empty or a distance is not finite.
pub(super) fn assign(cloud: &[DVec3], goal: &[DVec3]) -> Option<Assignment> {
    let count = cloud.len().min(goal.len()).min(EMD_LIMIT);
    let (from, to) = (thin(cloud, count), thin(goal, count));
    let distances: Vec<f64> = from.iter().flat_map(|&i| to.iter().map(move |&j| cloud[i].distance(goal[j]))).collect();
    if count == 0 || !distances.iter().all(|d| d.is_finite()) {
        return None;
    }
    let (rows, columns) = lsap::solve(count, count, &distances, false).ok()?;
    let mean = rows.iter().zip(&columns).map(|(&r, &c)| distances[r * count + c]).sum::<f64>() / count as f64;
    Some(Assignment { pairs: rows.iter().zip(&columns).map(|(&r, &c)| (from[r], to[c])).collect(), mean })
}

/// `count` rows spread evenly over a cloud of finite points: ordered along a Morton curve (1024 cells an axis, ties by row),
/// row `⌊(k + ½) n / count⌋` of that order is kept for every k.
///
/// Along such a curve every stretch of equal length holds equally many points, so density is kept; and the rows' order does
/// not matter where no two points share a cell.
fn thin(points: &[DVec3], count: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    if count < points.len() {
        let (low, high) =
            points.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| (l.min(*p), h.max(*p)));
        let scale = 1023.0 / (high - low).max_element().max(f64::MIN_POSITIVE);
        order.sort_by_cached_key(|&i| (morton((points[i] - low) * scale), i));
        order = (0..count).map(|k| order[(2 * k + 1) * points.len() / (2 * count)]).collect();
    }
    order
}

/// The bits of the three cell coordinates, interleaved.
fn morton(cell: DVec3) -> u32 {
    let spread = |axis: f64| (0..10).fold(0, |code, bit| code | (((axis as u32) >> bit & 1) << (3 * bit)));
    spread(cell.x) | spread(cell.y) << 1 | spread(cell.z) << 2
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metric::tests::cloud;

    #[test]
    fn morton_codes_interleave_bits() {
        assert_eq!(morton(DVec3::new(1.0, 0.0, 0.0)), 0b001);
        assert_eq!(morton(DVec3::new(0.0, 2.0, 3.0)), 0b110_100);
        assert_eq!(morton(DVec3::splat(1023.0)), (1 << 30) - 1);
    }

    #[test]
    fn thinning_keeps_density_and_forgets_the_order_of_rows() {
        let points = cloud(4000, 1);
        let kept: Vec<DVec3> = thin(&points, 400).iter().map(|&i| points[i]).collect();
        assert_eq!(kept.len(), 400);
        for octant in 0..8 {
            let inside = |p: &&DVec3| (0..3).all(|axis| (p[axis] > 0.5) == (octant >> axis & 1 == 1));
            let (all, few) = (points.iter().filter(inside).count(), kept.iter().filter(inside).count());
            assert!((few as f64 - all as f64 / 10.0).abs() <= 3.0, "octant {octant}: {few} of {all}");
        }
        let reversed: Vec<DVec3> = points.iter().rev().copied().collect();
        let again: Vec<DVec3> = thin(&reversed, 400).iter().map(|&i| reversed[i]).collect();
        assert_eq!(kept, again);
    }

    #[test]
    fn a_full_count_keeps_every_row_in_place() {
        assert_eq!(thin(&cloud(5, 2), 5), [0, 1, 2, 3, 4]);
    }
}
