//! The order in which a model sums over particles, which must not depend on how a scene numbers them.
use super::Scene;
use glam::DVec3;
use std::sync::Arc;

/// Lexicographic in position, then velocity now and ever further back, then body, at the start: sums then run in an order that does
/// not know how the scene numbered its particles, so relabelling them relabels the prediction bit for bit. Particles that differ
/// in nothing of this are alike to every model.
#[derive(Clone, Debug)]
pub struct Order(Arc<[u32]>);

impl Order {
    /// Of a scene's particles.
    pub fn of(scene: &Scene) -> Self {
        let Scene { particles, past, body, .. } = scene;
        let columns: Vec<&[DVec3]> =
            [&particles.positions, &particles.velocities].into_iter().chain(past).map(Vec::as_slice).collect();
        let numbers = |i: u32| columns.iter().flat_map(move |column| column[i as usize].to_array());
        let mut order: Vec<u32> = (0..particles.len() as u32).collect();
        order.sort_by(|&a, &b| {
            let differ = numbers(a).zip(numbers(b)).map(|(a, b)| a.total_cmp(&b)).find(|o| o.is_ne());
            differ.unwrap_or_else(|| body[a as usize].cmp(&body[b as usize]))
        });
        Self(order.into())
    }

    /// Rows of the scene in this order.
    pub fn gather<T: Copy>(&self, rows: &[T]) -> Vec<T> {
        self.0.iter().map(|&i| rows[i as usize]).collect()
    }

    /// Rows of this order as the scene has them.
    pub fn scatter(&self, rows: &[DVec3]) -> Vec<DVec3> {
        let mut out = vec![DVec3::ZERO; rows.len()];
        for (row, &i) in rows.iter().zip(self.0.iter()) {
            out[i as usize] = *row;
        }
        out
    }
}
