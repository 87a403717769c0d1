//! The compliant contact formula that particles, floor and tool share.
use anyhow::ensure;
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Constants of a compliant contact with Coulomb friction, per unit mass of the particle it pushes.
///
/// With overlap δ, outward normal n and relative velocity v (`v_n = v·n` separating, `v_t` the rest):
/// `N = k δ₊^{3/2} ρ(1 − d v_n)`, `a = N n − μ N v_t / √(|v_t|² + v_s²)`, where ρ(u) is max(0, u) with its corner rounded
/// off between −½ and ½ so that accelerations have a continuous derivative (Hunt & Crossley 1975; regularised Coulomb friction).
/// Stable for substeps `h ≤ 0.1 π √(1 / (3 k √δ))`; without drag, slow slip creeps.
///
/// With a tangential spring it does not: every contact remembers a stretch ξ in the surface, `ξ ← ξ + h v_t`, cut off at
/// `|ξ| = μ N/k_t` and forgotten when the contact ends, and `a = N n + T` with `T = −k_t ξ − μ N v_t/v_s`, cut off at `|T| = μ N`
/// (Cundall & Strack 1979, with a dashpot that alone reaches the limit at v_s).
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
    /// Stiffness k_t of the tangential spring over a particle's mass; left out, friction remembers nothing \[s^-2\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tangential_stiffness: Option<f64>,
}

/// Names of the constants, in the order of [`CompliantSpec::pull_constants`], that of the spring last.
const COMPLIANT: [&str; 6] = ["radius", "stiffness", "damping", "friction", "slip", "tangential_stiffness"];

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
        not_negative(law, "friction", self.friction)?;
        self.tangential_stiffness.map_or(Ok(()), |stiffness| positive(law, "tangential_stiffness", stiffness))
    }

    /// Whether friction has a spring.
    pub(super) fn springs(&self) -> bool {
        self.tangential_stiffness.is_some()
    }

    /// `0.1 π √(1/(3 k √δ))` at an overlap of half the radius, and `0.1 π √(1/(2 k_t))`, whichever is less \[s\].
    pub(super) fn stable(&self) -> f64 {
        let root = (0.5 * self.radius).sqrt();
        swing(3.0 * self.stiffness * root).min(swing(2.0 * self.tangential_stiffness.unwrap_or_default()))
    }

    /// Names of the constants that this has.
    pub(super) fn constants(&self) -> &'static [&'static str] {
        if self.springs() { &COMPLIANT } else { &COMPLIANT[..5] }
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
pub(super) fn ramp(u: f64) -> (f64, f64) {
    if u >= 0.5 {
        (u, 1.0)
    } else if u <= -0.5 {
        (0.0, 0.0)
    } else {
        (0.5 * (u + 0.5) * (u + 0.5), u + 0.5)
    }
}

/// Longest substep that a spring of `stiffness` = ω² \[s^-2\] bears, a twentieth of its period: `0.1 π/ω` \[s\].
pub(super) fn swing(stiffness: f64) -> f64 {
    0.1 * std::f64::consts::PI / stiffness.sqrt()
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
