//! Semi-implicit Euler: the velocity first, then the position by the new velocity.
use super::Integrator;
use crate::model::law::History;
use crate::model::particles::backward::{Backward, Owned};
use crate::model::particles::interval::Interval;
use crate::model::particles::rigid::RigidMotion;
use crate::model::particles::substeps::{Moment, Substeps};
use crate::model::particles::tape::Tape;
use crate::state::{Particles, ParticlesGrad};
use glam::DVec3;

/// `v ← κ v + h a`, `x ← x + h v`, the tool of substep k a fraction `(k + 1)/K` of its way; rigid bodies then move as a whole.
pub(super) struct SemiImplicitEuler;

impl Integrator for SemiImplicitEuler {
    fn advance(&self, interval: &Interval<'_>, mut tape: Option<&mut Tape>) -> (Particles, Vec<History>) {
        let bodies = &interval.state.rigid;
        let mut particles = interval.state.particles.clone();
        let mut substeps = Substeps::new(interval);
        let mut acceleration = vec![DVec3::ZERO; particles.len()];
        for k in 0..interval.substeps {
            let start = (!bodies.is_empty()).then(|| particles.positions.clone());
            substeps.ask(
                &particles,
                Moment { fraction: interval.fraction(k), duration: interval.h },
                &mut acceleration,
                tape.as_deref_mut(),
            );
            let Particles { positions, velocities } = &mut particles;
            for ((x, v), a) in positions.iter_mut().zip(velocities).zip(&acceleration) {
                *v = interval.keep * *v + interval.h * *a;
                *x += interval.h * *v;
            }
            let Some(start) = start else { continue };
            let impose = |rows: &Vec<u32>| RigidMotion::impose(rows, &start, &mut particles, interval.h);
            let rigid = bodies.iter().map(impose).collect();
            if let Some(tape) = &mut tape {
                tape.rigid.push(rigid);
            }
        }
        (particles, substeps.remembered())
    }

    /// With λ = `∂J/∂` of what follows: `λ_a = h (λ_v + h λ_x)`, `λ_v ← κ (λ_v + h λ_x) + (∂a/∂v)ᵀ λ_a`, `λ_x ← λ_x + (∂a/∂x)ᵀ λ_a`.
    fn pull(&self, back: &mut Backward<'_>, tape: &Tape, held: &mut [DVec3], owned: &mut Owned<'_>) {
        let interval = back.interval;
        let count = held.len();
        let bodies = &interval.state.rigid;
        let mut at = vec![DVec3::ZERO; count];
        let mut by_start = vec![DVec3::ZERO; if bodies.is_empty() { 0 } else { count }];
        for (k, asked) in tape.asked.iter().enumerate().rev() {
            for (rows, motion) in bodies.iter().zip(tape.rigid.get(k).into_iter().flatten()) {
                motion.pull(rows, interval.h, &mut back.particles, &mut by_start);
            }
            if let Some(by_keep) = owned.constants.first_mut() {
                *by_keep += keep_vjp(interval, &asked.particles, &back.particles);
            }
            let ParticlesGrad { positions, velocities } = &mut back.particles;
            for (i, (x, v)) in positions.iter().zip(velocities).enumerate() {
                let push = *v + interval.h * *x;
                *v = interval.keep * push;
                at[i] = interval.h * push;
                held[i] += at[i];
            }
            back.ask(asked, &at, owned);
            for (x, by) in back.particles.positions.iter_mut().zip(&mut by_start) {
                *x += std::mem::take(by);
            }
        }
    }
}

/// `∂J/∂keep` of one substep from `start`, `at` being the derivative by its end: `Σ (λ_v + h λ_x)·v keep^{1/K − 1}/K`.
fn keep_vjp(interval: &Interval<'_>, start: &Particles, at: &ParticlesGrad) -> f64 {
    let share = (interval.substeps as f64).recip();
    let rows = at.positions.iter().zip(&at.velocities).zip(&start.velocities);
    let sum: f64 = rows.map(|((x, v), start)| (*v + interval.h * *x).dot(*start)).sum();
    share * interval.model.keep.powf(share - 1.0) * sum
}
