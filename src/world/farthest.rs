//! Which of the simulator's particles models see.
use glam::DVec3;

/// The `count` points that repeated choice of the one farthest from all chosen before gives, from the first on.
pub(super) fn farthest(points: &[DVec3], count: usize) -> Vec<u32> {
    let mut distances = vec![f64::INFINITY; points.len()];
    let mut chosen = Vec::with_capacity(count);
    let mut next = 0;
    for _ in 0..count {
        chosen.push(next as u32);
        let from = points[next];
        let mut best = -1.0;
        for (i, (point, distance)) in points.iter().zip(&mut distances).enumerate() {
            *distance = distance.min(point.distance_squared(from));
            if *distance > best {
                (best, next) = (*distance, i);
            }
        }
    }
    chosen
}
