//! Velocity Verlet: half a kick, a drift, and the other half where it leads.
use super::Integrator;
use crate::model::law::History;
use crate::model::particles::backward::{Backward, Owned};
use crate::model::particles::interval::Interval;
use crate::model::particles::substeps::{Moment, Substeps};
use crate::model::particles::tape::Tape;
use crate::state::Particles;
use glam::DVec3;

/// `w = √κ v + h a/2`, `x ← x + h w`, `a ← a(x, √κ (w + h a/2))`, `v ← √κ (w + h a/2)`, drag in halves around the kicks (Strang
/// 1968); the tool stands at the start of its way for the first a, and a fraction `(k + 1)/K` of it along at the end of substep k.
pub(super) struct VelocityVerlet;

impl Integrator for VelocityVerlet {
    fn advance(&self, interval: &Interval<'_>, mut tape: Option<&mut Tape>) -> (Particles, Vec<History>) {
        let (h, root) = (interval.h, interval.keep.sqrt());
        let mut particles = interval.state.particles.clone();
        let mut substeps = Substeps::new(interval);
        let mut acceleration = vec![DVec3::ZERO; particles.len()];
        let mut middle = acceleration.clone();
        substeps.ask(&particles, Moment { fraction: 0.0, duration: 0.0 }, &mut acceleration, tape.as_deref_mut());
        for k in 0..interval.substeps {
            let Particles { positions, velocities } = &mut particles;
            let rows = positions.iter_mut().zip(velocities).zip(&mut middle).zip(&acceleration);
            for (((x, v), w), a) in rows {
                *w = root * *v + 0.5 * h * *a;
                *x += h * *w;
                *v = root * (*w + 0.5 * h * *a);
            }
            substeps.ask(
                &particles,
                Moment { fraction: interval.fraction(k), duration: h },
                &mut acceleration,
                tape.as_deref_mut(),
            );
            for ((v, w), a) in particles.velocities.iter_mut().zip(&middle).zip(&acceleration) {
                *v = root * (*w + 0.5 * h * *a);
            }
            if let Some(tape) = &mut tape {
                tape.velocities.push(particles.velocities.clone());
            }
        }
        (particles, substeps.remembered())
    }

    /// With p the predicted velocity and λ = `∂J/∂` of what follows: `λ_a' += √κ h/2 λ_v`, `λ_p = (∂a'/∂p)ᵀ λ_a'`,
    /// `λ_x += (∂a'/∂x)ᵀ λ_a'`, `λ_w = √κ (λ_v + λ_p) + h λ_x`, `λ_a = h/2 (√κ λ_p + λ_w)`, `λ_v ← √κ λ_w`.
    fn pull(&self, back: &mut Backward<'_>, tape: &Tape, held: &mut [DVec3], owned: &mut Owned<'_>) {
        let interval = back.interval;
        let (h, root) = (interval.h, interval.keep.sqrt());
        let (count, substeps) = (held.len(), interval.substeps);
        let mut at = vec![DVec3::ZERO; count];
        let mut by_end = vec![DVec3::ZERO; count];
        let mut by_root = 0.0;
        for k in (0..substeps).rev() {
            by_end.swap_with_slice(&mut back.particles.velocities);
            back.particles.velocities.fill(DVec3::ZERO);
            for ((at, held), by_end) in at.iter_mut().zip(&mut *held).zip(&by_end) {
                *at += 0.5 * h * root * *by_end;
                *held += *at;
            }
            let asked = &tape.asked[k + 1];
            back.ask(asked, &at, owned);
            let before = if k > 0 { &tape.velocities[k - 1] } else { &interval.state.particles.velocities };
            let rows = back.particles.positions.iter().zip(&mut back.particles.velocities);
            for (i, (x, v)) in rows.enumerate() {
                let (by_predicted, by_middle) = (*v, root * (by_end[i] + *v) + h * *x);
                at[i] = 0.5 * h * (root * by_predicted + by_middle);
                *v = root * by_middle;
                // Both velocities are √κ times what the derivative by it is.
                let ends = by_end[i].dot(tape.velocities[k][i]) + by_predicted.dot(asked.particles.velocities[i]);
                by_root += ends / root + by_middle.dot(before[i]);
            }
        }
        held.iter_mut().zip(&at).for_each(|(held, at)| *held += *at);
        back.ask(&tape.asked[0], &at, owned);
        if let Some(by_keep) = owned.constants.first_mut() {
            let share = 0.5 * (substeps as f64).recip();
            *by_keep += share * interval.model.keep.powf(share - 1.0) * by_root;
        }
    }
}
