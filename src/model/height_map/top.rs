//! The height map: how high the highest particle over each cell is, as a camera above would see it.
use super::GridSpec;
use glam::{DVec2, DVec3};

/// `h_c = max(0, maxᵢ zᵢ k(|c − xᵢ|/ρ))` \[m\] with `k(s) = (1 − s⁴)²` up to s = 1: flat over a particle, continuous where it ends.
pub(crate) struct Top {
    /// h of each cell.
    pub(crate) heights: Vec<f64>,
    /// The particle that is highest over each cell.
    highest: Vec<Option<u32>>,
    radius: f64,
}

impl Top {
    pub(crate) fn of(grid: &GridSpec, radius: f64, positions: &[DVec3]) -> Self {
        let cells = grid.size().cells();
        let mut top = Self { heights: vec![0.0; cells], highest: vec![None; cells], radius };
        for (i, x) in positions.iter().enumerate() {
            for (cell, middle) in grid.around(x.truncate(), radius) {
                let height = x.z * top.bump(x.truncate() - middle).0;
                if height > top.heights[cell] {
                    top.heights[cell] = height;
                    top.highest[cell] = Some(i as u32);
                }
            }
        }
        top
    }

    /// k at an offset, and its derivative by the offset.
    fn bump(&self, offset: DVec2) -> (f64, DVec2) {
        let square = offset.length_squared() / (self.radius * self.radius);
        let rest = (1.0 - square * square).max(0.0);
        (rest * rest, -8.0 * rest * square / (self.radius * self.radius) * offset)
    }

    /// Adds `∂J/∂positions` from `∂J/∂h`.
    pub(crate) fn pull(&self, grid: &GridSpec, positions: &[DVec3], at: &[f64], out: &mut [DVec3]) {
        for ((middle, highest), at) in grid.middles().zip(&self.highest).zip(at) {
            let Some(i) = highest.map(|i| i as usize) else { continue };
            let (bump, slope) = self.bump(positions[i].truncate() - middle);
            out[i] += *at * (positions[i].z * slope).extend(bump);
        }
    }
}
