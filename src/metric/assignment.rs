//! The optimal one-to-one assignment between two clouds of one size.
use glam::DVec3;

/// Which row of the goal each row of a cloud is carried to.
pub(super) struct Assignment {
    /// (row of the cloud, row of the goal); every row of both appears once.
    pub(super) pairs: Vec<(usize, usize)>,
    /// Mean distance of the pairs \[m\].
    pub(super) mean: f64,
}

/// The exact assignment of least mean distance (Crouse 2016, shortest augmenting paths).
///
/// `None` when the clouds are empty, of unequal sizes, or a distance is not finite.
pub(super) fn assign(cloud: &[DVec3], goal: &[DVec3]) -> Option<Assignment> {
    let count = cloud.len();
    let distances: Vec<f64> = cloud.iter().flat_map(|p| goal.iter().map(|q| p.distance(*q))).collect();
    if count == 0 || count != goal.len() || !distances.iter().all(|d| d.is_finite()) {
        return None;
    }
    let (rows, columns) = lsap::solve(count, count, &distances, false).ok()?;
    let mean = rows.iter().zip(&columns).map(|(&r, &c)| distances[r * count + c]).sum::<f64>() / count as f64;
    Some(Assignment { pairs: rows.into_iter().zip(columns).collect(), mean })
}
