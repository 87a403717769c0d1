//! Bodies that keep their shape: where laws take their particles in a substep, the nearest rigid motion of the body takes them.
use crate::state::{Particles, ParticlesGrad, rotation_between, rotation_between_vjp};
use glam::{DQuat, DVec3};

/// One body's motion in one substep of duration h: `x'ᵢ ← x̄' + R (xᵢ − x̄)` with R of least `Σ |R (xᵢ − x̄) − (x'ᵢ − x̄')|²`, and
/// `v'ᵢ ← (x'ᵢ − xᵢ)/h` (shape matching, Müller et al. 2005, eq. 3 to 9).
///
/// Momentum is kept, as all of its particles weigh the same; distances inside the body are kept to rounding.
pub(super) struct RigidMotion {
    rotation: DQuat,
    /// `R (xᵢ − x̄)` \[m\].
    arms: Vec<DVec3>,
    /// `x'ᵢ − x̄'` of what the laws did \[m\].
    ends: Vec<DVec3>,
}

impl RigidMotion {
    /// Moves the particles in `rows`, which `before` has at the start of the substep of `h` \[s\] and `after` where laws took them.
    pub(super) fn impose(rows: &[u32], before: &[DVec3], after: &mut Particles, h: f64) -> Self {
        let rows = || rows.iter().map(|&i| i as usize);
        let share = (rows().count() as f64).recip();
        let from = share * rows().map(|i| before[i]).sum::<DVec3>();
        let to = share * rows().map(|i| after.positions[i]).sum::<DVec3>();
        let ends: Vec<DVec3> = rows().map(|i| after.positions[i] - to).collect();
        let rotation = rotation_between(rows().map(|i| before[i] - from).zip(ends.iter().copied()));
        let arms: Vec<DVec3> = rows().map(|i| rotation * (before[i] - from)).collect();
        for (i, arm) in rows().zip(&arms) {
            after.positions[i] = to + *arm;
            after.velocities[i] = (after.positions[i] - before[i]) / h;
        }
        Self { rotation, arms, ends }
    }

    /// Turns `at`, the derivative by positions and velocities that this motion gave, into the one by what the laws did; adds the one
    /// by positions at the start of the substep to `start`.
    pub(super) fn pull(&self, rows: &[u32], h: f64, at: &mut ParticlesGrad, start: &mut [DVec3]) {
        let rows = || rows.iter().map(|&i| i as usize);
        let share = (self.arms.len() as f64).recip();
        let mut by_place = Vec::with_capacity(self.arms.len());
        for i in rows() {
            let by_velocity = std::mem::take(&mut at.velocities[i]) / h;
            start[i] -= by_velocity;
            by_place.push(at.positions[i] + by_velocity);
        }
        let mean = share * by_place.iter().sum::<DVec3>();
        let turn: DVec3 = self.arms.iter().zip(&by_place).map(|(arm, by)| arm.cross(*by)).sum();
        let pairs = self.arms.iter().copied().zip(self.ends.iter().copied());
        let lambda = rotation_between_vjp(pairs, turn);
        let back = self.rotation.conjugate();
        // Arms are centred, so that their derivatives are too: those of ends sum to zero by themselves.
        let by_arms: Vec<DVec3> = by_place.iter().zip(&self.ends).map(|(by, end)| *by + end.cross(lambda)).collect();
        let middle = share * by_arms.iter().sum::<DVec3>();
        for (k, i) in rows().enumerate() {
            at.positions[i] = mean + lambda.cross(self.arms[k]);
            start[i] += back * (by_arms[k] - middle);
        }
    }
}
