//! A workpiece as it is and as it should be.
use crate::state::Particles;
use crate::tool::Workpiece;
use glam::DVec3;
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

/// Numbers of a point: its place.
pub(super) const POINT: usize = 3;

/// Two clouds of points in the frame of the workpiece: `(p − centre)/extent`, in an order that does not know how they are numbered,
/// so that a network says the same of every numbering to the last bit.
#[derive(Clone, Debug, PartialEq)]
pub struct Clouds {
    /// (N + M, 3), the workpiece as it is first.
    pub(super) points: Vec<[f32; POINT]>,
    /// N and M.
    pub(super) counts: [usize; 2],
}

impl Clouds {
    /// The points of a workpiece and of its goal \[m\], around the middle of the first on the table, `extent` \[m\] counting as one.
    pub fn new(current: &[DVec3], goal: &[DVec3], extent: f64) -> Self {
        let centre = Workpiece::around(&Particles::at_rest(current.to_vec())).centre;
        let framed = |cloud: &[DVec3]| {
            let mut rows: Vec<[f32; POINT]> =
                cloud.iter().map(|p| ((*p - centre) / extent).as_vec3().to_array()).collect();
            rows.sort_by(|a, b| {
                let axes = a.iter().zip(b).map(|(a, b)| a.total_cmp(b));
                axes.into_iter().find(|order| order.is_ne()).unwrap_or(std::cmp::Ordering::Equal)
            });
            rows
        };
        Self { points: [framed(current), framed(goal)].concat(), counts: [current.len(), goal.len()] }
    }

    /// The same turned about the vertical by an angle of at most `turn` \[rad\] to either side, every number disturbed by `noise`.
    pub(super) fn disturbed(&self, turn: f64, noise: f64, rng: &mut ChaCha8Rng) -> Self {
        let (sine, cosine) = (rng.random_range(-1.0..=1.0) * turn).sin_cos();
        let (sine, cosine) = (sine as f32, cosine as f32);
        let mut disturbed = self.clone();
        for [x, y, z] in &mut disturbed.points {
            (*x, *y) = (cosine * *x - sine * *y, sine * *x + cosine * *y);
            for number in [x, y, z] {
                *number += (noise * rng.sample::<f64, _>(StandardNormal)) as f32;
            }
        }
        disturbed
    }
}
