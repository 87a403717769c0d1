//! Poisson-disk sampling of a volume.
use super::Shape;
use glam::{DVec3, IVec3};
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use std::collections::HashMap;

/// Darts thrown per cube of side `radius`: a ball of that radius left empty is missed by a hundred of them on average.
const DARTS: f64 = 24.0;

/// Points of `region` at least `radius` \[m\] apart that leave no room for another of that distance, but for rare gaps.
///
/// Dart throwing (Cook 1986), which unlike growth from a seed also fills shapes of several pieces.
pub fn poisson_disk<S: Shape + ?Sized>(region: &S, radius: f64, rng: &mut ChaCha8Rng) -> Vec<DVec3> {
    assert!(radius > 0.0, "a Poisson-disk sample needs a positive radius");
    let (low, high) = region.bounds();
    let darts = (DARTS * ((high - low) / radius).max(DVec3::ONE).element_product()).ceil() as usize;
    let mut points = Vec::new();
    // Only looked up, never walked through, so that its order cannot matter.
    let mut cells: HashMap<IVec3, Vec<u32>> = HashMap::new();
    for _ in 0..darts {
        let point = low + (high - low) * DVec3::new(rng.random(), rng.random(), rng.random());
        if !region.contains(point) {
            continue;
        }
        let cell = ((point - low) / radius).floor().as_ivec3();
        let around = (0..27).filter_map(|k| cells.get(&(cell + IVec3::new(k % 3, k / 3 % 3, k / 9) - 1)));
        if around.flatten().all(|&i: &u32| point.distance_squared(points[i as usize]) >= radius * radius) {
            cells.entry(cell).or_default().push(points.len() as u32);
            points.push(point);
        }
    }
    points
}

/// A Poisson-disk sample of at least `count` points, about four times as many where the shape is not thin.
pub(super) fn dense_enough<S: Shape + ?Sized>(region: &S, count: usize, rng: &mut ChaCha8Rng) -> Vec<DVec3> {
    // Dart throwing packs about 0.6 points into radius³.
    let mut radius = (0.6 * region.volume() / (4.0 * count.max(1) as f64)).cbrt();
    loop {
        let points = poisson_disk(region, radius, rng);
        if points.len() >= count {
            return points;
        }
        radius *= 0.8;
    }
}

#[cfg(test)]
mod tests {
    use super::super::ShapeSpec;
    use super::*;
    use rand::SeedableRng;

    fn shape(text: &str) -> Box<dyn Shape> {
        serde_json::from_str::<ShapeSpec>(text).unwrap().build().unwrap()
    }

    #[test]
    fn samples_keep_their_distance_and_leave_no_room() {
        let ring = shape(r#"{"kind": "ring", "outer": 0.06, "inner": 0.03, "thickness": 0.02}"#);
        let (mut rng, radius) = (ChaCha8Rng::seed_from_u64(1), 0.004);
        let points = poisson_disk(&*ring, radius, &mut rng);
        for (i, p) in points.iter().enumerate() {
            assert!(ring.contains(*p));
            assert!(points[..i].iter().all(|q| q.distance(*p) >= radius));
        }
        let (low, high) = ring.bounds();
        let mut gaps = 0;
        for _ in 0..20_000 {
            let at = low + (high - low) * DVec3::new(rng.random(), rng.random(), rng.random());
            gaps += usize::from(ring.contains(at) && points.iter().all(|p| p.distance(at) >= radius));
        }
        assert!(gaps < 60, "{gaps} of 20000 places still have room");
    }

    #[test]
    fn points_are_exactly_as_many_as_asked_for_and_the_same_for_the_same_stream() {
        let i = shape(r#"{"kind": "letter", "character": "i", "height": 0.06, "thickness": 0.001}"#);
        for count in [0, 1, 7, 300] {
            let draw = |seed| i.points(count, &mut ChaCha8Rng::seed_from_u64(seed));
            assert_eq!(draw(1).len(), count);
            assert!(draw(1).iter().all(|p| i.contains(*p)));
            assert_eq!(draw(1), draw(1));
            assert!(count == 0 || draw(1) != draw(2));
        }
    }
}
