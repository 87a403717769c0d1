//! Removing what is not the object from a cloud.
use glam::{DVec3, IVec3};
use std::collections::HashSet;

/// One point (the first) of each cube of side `width` \[m\], in the cloud's order.
pub(super) fn thin(points: &[DVec3], width: f64) -> Vec<DVec3> {
    let mut seen: HashSet<IVec3> = HashSet::new();
    points.iter().copied().filter(|p| seen.insert((*p / width).floor().as_ivec3())).collect()
}

/// The points whose mean distance to their `neighbours` nearest is at most mean + `sigmas` standard deviations of all such
/// distances (Rusu et al. 2008).
pub(super) fn without_outliers(points: &[DVec3], neighbours: usize, sigmas: f64) -> Vec<DVec3> {
    let neighbours = neighbours.min(points.len().saturating_sub(1));
    if neighbours == 0 {
        return points.to_vec();
    }
    let spread = |at: &DVec3| {
        let mut squared: Vec<f64> = points.iter().map(|p| p.distance_squared(*at)).collect();
        // The nearest is the point itself.
        squared.select_nth_unstable_by(neighbours, f64::total_cmp);
        squared[..=neighbours].sort_by(f64::total_cmp);
        squared[1..=neighbours].iter().map(|d| d.sqrt()).sum::<f64>() / neighbours as f64
    };
    let spreads: Vec<f64> = points.iter().map(spread).collect();
    let mean = spreads.iter().sum::<f64>() / spreads.len() as f64;
    let variance = spreads.iter().map(|s| (s - mean) * (s - mean)).sum::<f64>() / spreads.len() as f64;
    let limit = mean + sigmas * variance.sqrt();
    points.iter().zip(&spreads).filter(|(_, s)| **s <= limit).map(|(p, _)| *p).collect()
}

/// The largest set of points joined by steps of at most `step` \[m\]; of equal ones the first.
pub(super) fn largest_cluster(points: &[DVec3], step: f64) -> Vec<DVec3> {
    let mut label = vec![usize::MAX; points.len()];
    let mut sizes = Vec::new();
    for first in 0..points.len() {
        if label[first] != usize::MAX {
            continue;
        }
        let name = sizes.len();
        label[first] = name;
        let mut front = vec![first];
        let mut size = 0;
        while let Some(i) = front.pop() {
            size += 1;
            for j in 0..points.len() {
                if label[j] == usize::MAX && points[i].distance_squared(points[j]) <= step * step {
                    label[j] = name;
                    front.push(j);
                }
            }
        }
        sizes.push(size);
    }
    let best = (0..sizes.len()).fold(0, |best, i| if sizes[i] > sizes[best] { i } else { best });
    points.iter().zip(&label).filter(|(_, l)| **l == best).map(|(p, _)| *p).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(count: usize, width: f64, at: DVec3) -> Vec<DVec3> {
        (0..count * count).map(|i| at + width * DVec3::new((i % count) as f64, (i / count) as f64, 0.0)).collect()
    }

    #[test]
    fn a_lonely_point_goes_and_the_rest_stays() {
        let mut points = grid(12, 0.002, DVec3::ZERO);
        points.insert(50, DVec3::new(0.01, 0.01, 0.02));
        assert_eq!(without_outliers(&points, 8, 2.0 * 3.0), grid(12, 0.002, DVec3::ZERO));
        assert_eq!(without_outliers(&points[..1], 8, 2.0), &points[..1]);
    }

    #[test]
    fn the_largest_cluster_is_kept_whole() {
        let mut points = grid(3, 0.002, DVec3::splat(0.1));
        points.extend(grid(5, 0.002, DVec3::ZERO));
        points.extend(grid(4, 0.002, DVec3::splat(-0.1)));
        assert_eq!(largest_cluster(&points, 0.0021), grid(5, 0.002, DVec3::ZERO));
        assert!(largest_cluster(&[], 1.0).is_empty());
    }

    #[test]
    fn thinning_keeps_one_point_a_cube() {
        let points = grid(10, 0.001, DVec3::splat(0.0005));
        assert_eq!(thin(&points, 0.002).len(), 25);
    }
}
