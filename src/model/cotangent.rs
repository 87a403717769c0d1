//! The derivative by a state of particles and tool poses, as the one flat list that a sweep over time carries.
use crate::state::{ParticlesGrad, PoseGrad};
use glam::DVec3;

/// `∂J/∂state`, flat as `[positions 3N | velocities 3N | past 3N each | poses 6 per part: translation, rotation]`.
#[derive(Clone, Debug)]
pub(super) struct StateGrad {
    pub(super) particles: ParticlesGrad,
    /// By the velocities of the past that the state carries.
    pub(super) past: Vec<Vec<DVec3>>,
    pub(super) poses: Vec<PoseGrad>,
}

impl StateGrad {
    /// Of `particles` alone, in a state of so many velocities of the past and tool parts.
    pub(super) fn of(particles: ParticlesGrad, past: usize, parts: usize) -> Self {
        let zero = vec![DVec3::ZERO; particles.positions.len()];
        Self { particles, past: vec![zero; past], poses: vec![PoseGrad::default(); parts] }
    }

    /// Reads the flat layout of `count` particles with `past` velocities of the past.
    pub(super) fn read(flat: &[f64], count: usize, past: usize) -> Self {
        let rows: Vec<DVec3> = flat.chunks_exact(3).map(DVec3::from_slice).collect();
        let (positions, rest) = rows.split_at(count);
        let (velocities, rest) = rest.split_at(count);
        let (before, poses) = rest.split_at(count * past);
        Self {
            past: (0..past).map(|k| before[k * count..(k + 1) * count].to_vec()).collect(),
            particles: ParticlesGrad { positions: positions.to_vec(), velocities: velocities.to_vec() },
            poses: poses.chunks_exact(2).map(|p| PoseGrad { translation: p[0], rotation: p[1] }).collect(),
        }
    }

    /// Writes the flat layout.
    pub(super) fn flat(&self) -> Vec<f64> {
        let poses = self.poses.iter().flat_map(|p| [p.translation, p.rotation]);
        let ParticlesGrad { positions, velocities } = &self.particles;
        let rows = positions.iter().chain(velocities).chain(self.past.iter().flatten()).copied().chain(poses);
        rows.flat_map(|v| v.to_array()).collect()
    }
}
