//! How accelerations become motion: one table of integrators, each with its adjoint.
use super::backward::{Backward, Owned};
use super::interval::Interval;
use super::tape::Tape;
use crate::model::law::History;
use crate::state::Particles;
use glam::DVec3;
use schemars::JsonSchema;
use semi_implicit_euler::SemiImplicitEuler;
use serde::{Deserialize, Serialize};
use velocity_verlet::VelocityVerlet;

mod semi_implicit_euler;
mod velocity_verlet;

/// Which integrator takes the particles through the substeps of h, `κ = keep^{1/K}` being what a substep keeps of the velocity and
/// a the summed acceleration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum IntegratorSpec {
    /// `v ← κ v + h a(x, v)`, `x ← x + h v`: of first order, symplectic where a does not depend on v.
    #[default]
    SemiImplicitEuler,
    /// `w = √κ v + h a/2`, `x ← x + h w`, `a ← a(x, √κ (w + h a/2))`, `v ← √κ (w + h a/2)`: of second order, symplectic where a
    /// does not depend on v (Swope et al. 1982). Laws that look at velocities see the one predicted for the end of the substep
    /// (Groot & Warren 1997, eq. 10 with λ = 1), which keeps the second order with damping too and asks once a substep; damping at
    /// a rate γ is stable for `h γ < 1` alone, half of what semi-implicit Euler bears.
    VelocityVerlet,
}

impl IntegratorSpec {
    pub(super) fn build(self) -> Box<dyn Integrator> {
        match self {
            Self::SemiImplicitEuler => Box::new(SemiImplicitEuler),
            Self::VelocityVerlet => Box::new(VelocityVerlet),
        }
    }

    /// Whether this is the integrator that configs leave unsaid.
    pub(super) fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

/// An integrator over the substeps of one interval.
pub(super) trait Integrator: Send + Sync {
    /// The particles at the end and what laws remember then; what happened goes onto the tape, where there is one.
    fn advance(&self, interval: &Interval<'_>, tape: Option<&mut Tape>) -> (Particles, Vec<History>);
    /// Pulls `∂J/∂particles` and what laws remember in `back` from the end of the interval to its start; adds the derivative by held accelerations to `held`.
    fn pull(&self, back: &mut Backward<'_>, tape: &Tape, held: &mut [DVec3], owned: &mut Owned<'_>);
}
