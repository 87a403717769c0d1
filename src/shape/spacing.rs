//! How far points are apart.
use glam::DVec3;

/// Median distance to the nearest neighbour \[m\]; `None` of fewer than two points.
pub fn spacing(points: &[DVec3]) -> Option<f64> {
    let nearest = |(i, p): (usize, &DVec3)| {
        let others = points.iter().enumerate().filter(|(j, _)| *j != i);
        others.map(|(_, q)| p.distance_squared(*q)).fold(f64::INFINITY, f64::min)
    };
    let mut squares: Vec<f64> = points.iter().enumerate().map(nearest).collect();
    squares.sort_by(f64::total_cmp);
    squares.get(squares.len() / 2).map(|median| median.sqrt()).filter(|median| median.is_finite())
}
