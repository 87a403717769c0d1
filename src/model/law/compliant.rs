//! The compliant contact formula that particles, floor and tool share.
use anyhow::ensure;
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Constants of a compliant contact with Coulomb friction, per unit mass of the particle it pushes.
///
/// With overlap δ, outward normal n and relative velocity v (`v_n = v·n` separating, `v_t` the rest):
/// `N = k δ₊^{3/2} ρ(1 − d v_n)`, `a = N n − μ N v_t / √(|v_t|² + v_s²)`, where ρ(u) is max(0, u) with its corner rounded
/// off between −½ and ½ so that accelerations have a continuous derivative (Hunt & Crossley 1975; regularised Coulomb friction). Stable for substeps `h ≤ 0.1 π √(1 / (3 k √δ))`; without drag, slow slip creeps.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CompliantSpec {
    /// Radius of a particle \[m\].
    #[schemars(range(min = 1e-6))]
    pub radius: f64,
    /// Stiffness k over a particle's mass \[m^-1/2 s^-2\].
    #[schemars(range(min = 0.0))]
    pub stiffness: f64,
    /// Damping d, the inverse of the separating speed at which a contact stops pushing \[s/m\].
    #[schemars(range(min = 0.0))]
    pub damping: f64,
    /// Coefficient of friction μ \[1\].
    #[schemars(range(min = 0.0))]
    pub friction: f64,
    /// Slip speed v_s below which friction falls off linearly \[m/s\].
    #[schemars(range(min = 1e-9))]
    pub slip: f64,
}

/// Names of the constants, in the order of [`CompliantSpec::pull_constants`].
pub(super) const COMPLIANT: [&str; 5] = ["radius", "stiffness", "damping", "friction", "slip"];

/// What the formula says pulls back onto: `∂J/∂(δ, n, v)`.
pub(in crate::model) struct ContactGrad {
    pub(in crate::model) overlap: f64,
    pub(in crate::model) normal: DVec3,
    pub(in crate::model) velocity: DVec3,
}

impl CompliantSpec {
    /// Whether every constant is possible.
    ///
    /// # Errors
    /// A sentence naming the constant of the law `law` that is not.
    pub(super) fn check(&self, law: &str) -> anyhow::Result<()> {
        positive(law, "radius", self.radius)?;
        positive(law, "slip", self.slip)?;
        not_negative(law, "stiffness", self.stiffness)?;
        not_negative(law, "damping", self.damping)?;
        not_negative(law, "friction", self.friction)
    }

    /// The acceleration at overlap δ > 0.
    #[inline]
    pub(super) fn acceleration(&self, overlap: f64, normal: DVec3, velocity: DVec3) -> DVec3 {
        let separating = velocity.dot(normal);
        let push = self.stiffness * overlap * overlap.sqrt() * ramp(1.0 - self.damping * separating).0;
        let sliding = velocity - separating * normal;
        let drag = self.friction * push / (sliding.length_squared() + self.slip * self.slip).sqrt();
        push * normal - drag * sliding
    }

    /// Pulls `at` = `∂J/∂acceleration` back to overlap, normal and velocity.
    #[inline]
    pub(super) fn pull(&self, overlap: f64, normal: DVec3, velocity: DVec3, at: DVec3) -> ContactGrad {
        let separating = velocity.dot(normal);
        let (rest, slope) = ramp(1.0 - self.damping * separating);
        let stretch = self.stiffness * overlap.sqrt();
        let base = stretch * overlap;
        let push = base * rest;
        let sliding = velocity - separating * normal;
        let inverse = (sliding.length_squared() + self.slip * self.slip).sqrt().recip();
        let along = at.dot(sliding);
        let by_push = at.dot(normal) - self.friction * inverse * along;
        let by_sliding = (-self.friction * push * inverse) * (at - sliding * (along * inverse * inverse));
        let by_separating = -self.damping * slope * base * by_push - by_sliding.dot(normal);
        ContactGrad {
            overlap: 1.5 * stretch * rest * by_push,
            normal: push * at - separating * by_sliding + by_separating * velocity,
            velocity: by_sliding + by_separating * normal,
        }
    }

    /// Pulls `at` = `∂J/∂acceleration` back to `∂J/∂(δ, k, d, μ, v_s)`: the radius counts as often as δ has it.
    pub(super) fn pull_constants(&self, overlap: f64, normal: DVec3, velocity: DVec3, at: DVec3) -> [f64; 5] {
        let separating = velocity.dot(normal);
        let (rest, slope) = ramp(1.0 - self.damping * separating);
        let root = overlap.sqrt();
        let unit = overlap * root * rest;
        let sliding = velocity - separating * normal;
        let inverse = (sliding.length_squared() + self.slip * self.slip).sqrt().recip();
        let along = inverse * at.dot(sliding);
        let by_push = at.dot(normal) - self.friction * along;
        let push = self.stiffness * unit;
        [
            1.5 * self.stiffness * root * rest * by_push,
            unit * by_push,
            -self.stiffness * overlap * root * slope * separating * by_push,
            -push * along,
            self.friction * push * self.slip * inverse * inverse * along,
        ]
    }
}

/// ρ(u) and ρ'(u): 0 below −½, u above ½, and (u + ½)²/2 between.
#[inline]
fn ramp(u: f64) -> (f64, f64) {
    if u >= 0.5 {
        (u, 1.0)
    } else if u <= -0.5 {
        (0.0, 0.0)
    } else {
        (0.5 * (u + 0.5) * (u + 0.5), u + 0.5)
    }
}

/// # Errors
/// When `value` is not a positive finite number.
pub(super) fn positive(law: &str, key: &str, value: f64) -> anyhow::Result<()> {
    ensure!(value > 0.0 && value.is_finite(), "{key} of the law {law:?} must be positive and finite, got {value}");
    Ok(())
}

/// # Errors
/// When `value` is negative or not finite.
pub(super) fn not_negative(law: &str, key: &str, value: f64) -> anyhow::Result<()> {
    ensure!(value >= 0.0 && value.is_finite(), "{key} of the law {law:?} must be at least 0 and finite, got {value}");
    Ok(())
}
