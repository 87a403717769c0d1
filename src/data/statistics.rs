//! Scales of the motion in some episodes, by which networks and losses are normalised.
use super::Episode;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// A particle that moves less than this in a control step is at rest \[m\].
const AT_REST: f64 = 1e-5;

/// Means and standard deviations per axis, in metres per control step as LagrangeBench (Toshev et al. 2023) counts them, and
/// the typical displacement.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Statistics {
    /// Mean displacement per control step \[m\].
    pub vel_mean: [f64; 3],
    /// Its standard deviation \[m\]; 1 where nothing moves.
    pub vel_std: [f64; 3],
    /// Mean change of the displacement from one control step to the next \[m\].
    pub acc_mean: [f64; 3],
    /// Its standard deviation \[m\]; 1 where nothing moves.
    pub acc_std: [f64; 3],
    /// Root mean square displacement per control step of the particles that move more than 0.01 mm in it \[m\]; 1 if none.
    pub displacement: f64,
}

impl Statistics {
    /// Of all particles in all steps of `episodes`.
    pub fn of<'a>(episodes: impl IntoIterator<Item = &'a Episode>) -> Self {
        let episodes: Vec<_> = episodes.into_iter().collect();
        let steps = episodes.iter().flat_map(|e| e.states.windows(2));
        let moves = steps.flat_map(|s| s[0].positions.iter().zip(&s[1].positions)).map(|(a, b)| b - a);
        let triples = episodes.iter().flat_map(|e| e.states.windows(3));
        let changes = triples
            .flat_map(|s| s[0].positions.iter().zip(&s[1].positions).zip(&s[2].positions))
            .map(|((a, b), c)| (c - b) - (b - a));
        let (vel_mean, vel_std) = moments(moves.clone());
        let (acc_mean, acc_std) = moments(changes);
        let (sum, count) = moves
            .filter(|d| d.length() > AT_REST)
            .fold((0.0, 0usize), |(sum, count), d| (sum + d.length_squared(), count + 1));
        let displacement = if count == 0 { 1.0 } else { (sum / count as f64).sqrt() };
        Self { vel_mean, vel_std, acc_mean, acc_std, displacement }
    }
}

/// Mean and standard deviation per axis, in two passes.
fn moments(values: impl Iterator<Item = DVec3> + Clone) -> ([f64; 3], [f64; 3]) {
    let (sum, count) = values.clone().fold((DVec3::ZERO, 0usize), |(sum, count), v| (sum + v, count + 1));
    let mean = sum / count.max(1) as f64;
    let spread = values.map(|v| (v - mean) * (v - mean)).sum::<DVec3>() / count.max(1) as f64;
    let std = spread.to_array().map(|s| if s.sqrt() < 1e-7 { 1.0 } else { s.sqrt() });
    (mean.to_array(), std)
}

#[cfg(test)]
mod tests {
    use super::super::made_up;
    use super::*;

    #[test]
    fn a_known_motion_has_the_moments_it_should() {
        // Particle 0 rests; particle 1 moves 2 mm, then 4 mm along x and always 1 mm along z.
        let mut episode = made_up(2);
        for (t, state) in episode.states.iter_mut().enumerate() {
            let x = [0.0, 0.002, 0.006][t];
            state.positions = vec![DVec3::ZERO, DVec3::new(x, 0.0, 0.001 * t as f64)];
        }
        let s = Statistics::of([&episode]);
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} is not {b}");
        close(s.vel_mean[0], 0.0015);
        close(s.vel_std[0], ((2.0 * 0.0015f64.powi(2) + 0.0005f64.powi(2) + 0.0025f64.powi(2)) / 4.0).sqrt());
        close(s.vel_std[1], 1.0);
        close(s.acc_mean[0], 0.001);
        close(s.acc_std[0], 0.001);
        close(s.acc_std[2], 1.0);
        close(s.displacement, ((4e-6 + 1e-6 + 16e-6 + 1e-6) / 2.0f64).sqrt());
    }
}
