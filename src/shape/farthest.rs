//! Farthest point sampling.
use glam::DVec3;

/// [`farthest_points_from`] the point farthest from the centroid.
pub fn farthest_points(points: &[DVec3], count: usize) -> Vec<usize> {
    let centroid = points.iter().sum::<DVec3>() / points.len().max(1) as f64;
    let gap: Vec<f64> = points.iter().map(|p| p.distance_squared(centroid)).collect();
    farthest_points_from(points, widest(&gap), count)
}

/// Numbers of `count` of the `points` (all, when there are fewer): `first`, then each the farthest from those before it.
///
/// Ties go to the lower number. O(N · count) (Eldar, Lindenbaum, Porat & Zeevi 1997).
pub fn farthest_points_from(points: &[DVec3], first: usize, count: usize) -> Vec<usize> {
    let count = count.min(points.len());
    let mut gap = vec![f64::INFINITY; points.len()];
    let mut chosen = Vec::with_capacity(count);
    let mut next = first;
    while chosen.len() < count {
        for (gap, point) in gap.iter_mut().zip(points) {
            *gap = gap.min(point.distance_squared(points[next]));
        }
        // Below every distance, so that coinciding points are still taken once each.
        gap[next] = -1.0;
        chosen.push(next);
        next = widest(&gap);
    }
    chosen
}

fn widest(gap: &[f64]) -> usize {
    (0..gap.len()).fold(0, |best, i| if gap[i] > gap[best] { i } else { best })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn random(count: usize, seed: u64) -> Vec<DVec3> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        (0..count).map(|_| DVec3::new(rng.random(), rng.random(), rng.random())).collect()
    }

    #[test]
    fn every_choice_is_the_farthest_from_those_before() {
        let points = random(200, 1);
        let chosen = farthest_points(&points, 40);
        for k in 1..40 {
            let gap = |p: DVec3| chosen[..k].iter().map(|&c| points[c].distance(p)).fold(f64::INFINITY, f64::min);
            let best = points.iter().map(|&p| gap(p)).fold(0.0, f64::max);
            assert_eq!(gap(points[chosen[k]]), best);
        }
    }

    #[test]
    fn every_point_is_taken_once_even_where_points_coincide() {
        let mut points = random(20, 2);
        points.extend(vec![DVec3::ONE; 10]);
        let mut all = farthest_points(&points, 99);
        all.sort_unstable();
        assert_eq!(all, (0..30).collect::<Vec<_>>());
        assert!(farthest_points(&[], 3).is_empty());
    }
}
