//! The table under a cloud.
use glam::{DMat3, DVec3};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// The plane `z = height + slope_x x + slope_y y`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Height above the origin \[m\].
    pub height: f64,
    /// ∂z/∂x.
    pub slope_x: f64,
    /// ∂z/∂y.
    pub slope_y: f64,
}

/// Trials of the random search; three of four points being off the table, one trial in 64 still sees it.
const TRIALS: usize = 1000;
/// Steepest table looked for: 6° is more than any calibration is off.
const STEEPEST: f64 = 0.1;
/// Share of the cloud that noise may put below the table.
const BELOW: f64 = 0.02;

impl Plane {
    /// Height of `point` above the plane, measured along z \[m\].
    pub fn above(&self, point: DVec3) -> f64 {
        point.z - self.height - self.slope_x * point.x - self.slope_y * point.y
    }

    /// The nearly level plane with most points within `tolerance` \[m\] and nearly none below it, or `None` when that is less
    /// than a tenth of the cloud.
    ///
    /// RANSAC (Fischler & Bolles 1981) with a fixed stream, then least squares on the points within `tolerance`. The bound on
    /// points below keeps a flat top from being taken for the table.
    pub fn under(cloud: &[DVec3], tolerance: f64) -> Option<Self> {
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        let allowed = (BELOW * cloud.len() as f64) as usize;
        let (mut best, mut most) = (None, cloud.len() / 10);
        for _ in 0..if cloud.len() < 3 { 0 } else { TRIALS } {
            let three: [DVec3; 3] = std::array::from_fn(|_| cloud[rng.random_range(0..cloud.len())]);
            let Some(plane) = Self::through(&three) else { continue };
            let within = cloud.iter().filter(|p| plane.above(**p).abs() <= tolerance).count();
            if within > most && cloud.iter().filter(|p| plane.above(**p) < -tolerance).count() <= allowed {
                (best, most) = (Some(plane), within);
            }
        }
        let mut plane = best?;
        for _ in 0..5 {
            let within: Vec<_> = cloud.iter().copied().filter(|p| plane.above(*p).abs() <= tolerance).collect();
            plane = Self::through(&within).unwrap_or(plane);
        }
        Some(plane)
    }

    /// Least squares in z, or `None` when the points fix no nearly level plane.
    fn through(points: &[DVec3]) -> Option<Self> {
        let mean = points.iter().sum::<DVec3>() / points.len() as f64;
        let centred = points.iter().map(|p| *p - mean);
        let second = centred.fold(DMat3::ZERO, |m, d| m + DMat3::from_cols(d * d.x, d * d.y, d * d.z));
        let (xx, xy, yy) = (second.x_axis.x, second.x_axis.y, second.y_axis.y);
        let determinant = xx * yy - xy * xy;
        let slope_x = (second.x_axis.z * yy - second.y_axis.z * xy) / determinant;
        let slope_y = (second.y_axis.z * xx - second.x_axis.z * xy) / determinant;
        let height = mean.z - slope_x * mean.x - slope_y * mean.y;
        // Also false for the infinities and NaN of a vanishing determinant.
        (slope_x.hypot(slope_y) <= STEEPEST).then_some(Self { height, slope_x, slope_y })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene(table: usize, top: usize) -> Vec<DVec3> {
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let mut noise = move || rng.random_range(-1.0..1.0);
        let on_table = |n: f64, m: f64, z: f64| DVec3::new(0.4 + 0.1 * n, 0.1 * m, 0.01 + 0.002 * n - 0.003 * m + z);
        let mut cloud: Vec<_> = (0..table).map(|_| on_table(noise(), noise(), 5e-4 * noise())).collect();
        cloud.extend((0..top).map(|_| on_table(0.3 * noise(), 0.3 * noise(), 0.03 + 5e-4 * noise())));
        cloud
    }

    #[test]
    fn the_table_is_found_under_a_larger_flat_top() {
        let plane = Plane::under(&scene(600, 1400), 1.5e-3).unwrap();
        assert!((plane.slope_x - 0.02).abs() < 2e-3 && (plane.slope_y + 0.03).abs() < 2e-3, "{plane:?}");
        assert!(plane.above(DVec3::new(0.4, 0.0, 0.01)).abs() < 2e-4, "{plane:?}");
        assert_eq!(Some(plane), Plane::under(&scene(600, 1400), 1.5e-3));
    }

    #[test]
    fn no_table_is_no_plane() {
        let slope = (0..500).map(|i| DVec3::new(i as f64 / 500.0, (i * 7 % 500) as f64 / 500.0, i as f64 / 500.0));
        assert_eq!(Plane::under(&slope.collect::<Vec<_>>(), 1e-3), None);
        assert_eq!(Plane::under(&[DVec3::ZERO; 20], 1e-3), None);
        assert_eq!(Plane::under(&[], 1e-3), None);
    }
}
