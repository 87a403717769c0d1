//! The order of points along a space-filling curve.
use glam::DVec3;

/// The rows of a cloud of finite points along a Morton curve (Morton 1966), 1024 cells an axis, ties by row.
///
/// Points that are near in this order are near in space, and the order does not depend on that of the rows where no two points
/// share a cell.
pub(super) fn along_curve(points: &[DVec3]) -> Vec<usize> {
    let (low, high) = points.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| (l.min(*p), h.max(*p)));
    let scale = 1023.0 / (high - low).max_element().max(f64::MIN_POSITIVE);
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by_cached_key(|&i| (morton((points[i] - low) * scale), i));
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
    fn the_order_is_that_of_space_and_forgets_that_of_the_rows() {
        let points = cloud(1000, 1);
        let along: Vec<DVec3> = along_curve(&points).into_iter().map(|i| points[i]).collect();
        let step = |p: &[DVec3]| p.windows(2).map(|w| w[0].distance(w[1])).sum::<f64>() / 999.0;
        assert!(step(&along) < 0.3 * step(&points), "{} against {}", step(&along), step(&points));
        let reversed: Vec<DVec3> = points.iter().rev().copied().collect();
        let again: Vec<DVec3> = along_curve(&reversed).into_iter().map(|i| reversed[i]).collect();
        assert_eq!(along, again);
    }
}
