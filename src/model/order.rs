//! The order that models keep particles in: one that does not know how the scene numbered them.
use crate::state::Scene;
use glam::DVec3;
use std::sync::Arc;

/// Row of the scene that each canonical row came from: lexicographic in position, then velocity, then body, at the start.
///
/// Sums over neighbours then run in the same order however the scene numbered its particles, so relabelling them relabels the
/// prediction bit for bit.
#[derive(Clone, Debug)]
pub(super) struct Order(Arc<[u32]>);

impl Order {
    /// Of a scene's particles.
    pub(super) fn of(scene: &Scene) -> Self {
        let particles = &scene.particles;
        let key = |i: u32| {
            let (x, v) = (particles.positions[i as usize], particles.velocities[i as usize]);
            [x.x, x.y, x.z, v.x, v.y, v.z]
        };
        let mut order: Vec<u32> = (0..particles.len() as u32).collect();
        order.sort_by(|&a, &b| {
            let pairs = key(a).into_iter().zip(key(b));
            let differ = pairs.map(|(a, b)| a.total_cmp(&b)).find(|o| o.is_ne());
            differ.unwrap_or_else(|| scene.body[a as usize].cmp(&scene.body[b as usize]))
        });
        Self(order.into())
    }

    /// Rows of the scene in canonical order.
    pub(super) fn gather<T: Copy>(&self, rows: &[T]) -> Vec<T> {
        self.0.iter().map(|&i| rows[i as usize]).collect()
    }

    /// Canonical rows in the scene's order.
    pub(super) fn scatter(&self, rows: &[DVec3]) -> Vec<DVec3> {
        let mut out = vec![DVec3::ZERO; rows.len()];
        for (row, &i) in rows.iter().zip(self.0.iter()) {
            out[i as usize] = *row;
        }
        out
    }
}
