//! The moving least squares material point method (Hu et al. 2018) with a hand-written adjoint: dough as a continuum that
//! particles carry through a grid.
//!
//! A particle has a position x, a velocity v, its gradient C (affine, Jiang et al. 2015) and the elastic left Cauchy–Green tensor
//! b. All particles weigh the same, and each holds the volume of its mass at the material's density, so that the mass itself does
//! not matter. One control step is K substeps of h; in each, with quadratic B-splines w on cells of Δ and offsets `d = xᵢ − x`,
//!
//! ```text
//! T = (I + hC) b (I + hC)ᵀ,   b ← elastic part of T,   τ = Kirchhoff's stress + η (C + Cᵀ)
//! mᵢ = Σ w,   mᵢ uᵢ = Σ w (v + (C − 4h/Δ² τ/ρ) d),   uᵢ ← contact(uᵢ − h g ẑ)
//! v ← Σ w uᵢ,   C ← 4/Δ² Σ w uᵢ dᵀ,   x ← x + h v
//! ```
//!
//! b stands for the deformation gradient F of other writings, `b = F Fᵀ`: stress and flow of an isotropic material see no more of
//! F (Simo & Hughes 1998, section 9.2). K is chosen so that neither sound nor momentum crosses more than the share `courant` of a
//! cell in a substep: `K = ⌈T (c/Δ + 4η/(ρΔ²)) / courant⌉` with `c² = (λ + 2μ)/ρ`.
//!
//! With `precision = "single"` the points' velocities and tensors, the stencils, the grid, the spectra and the flow are f32, and so
//! is the adjoint of all of it. Places stay f64, because away from the origin a creeping point's way in a substep is less than
//! f32 can add to its place; so do the contacts of nodes, which are few beside points times stencils. Over the 15 steps of the
//! quickstart's actions, points end within 2·10⁻⁴ of the way they moved from where double has them, and derivatives by the
//! controls differ by 10⁻³ of their length. How little faster it is `experiments mpm_speed` tells; its tapes are little more than
//! half as long. A node is four numbers, in one register either way, so that only the spectra, in three sweeps instead of four, and
//! the memory gain.
use super::{Adjoint, Checkpoints, Dynamics};
use crate::state::{Control, Particles, Scene};
use anyhow::ensure;
use continuum::Stepping;
use material::Material;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use state::Points;

mod adjoint;
mod contact;
mod continuum;
mod grid;
mod interval;
mod material;
mod real;
mod spectrum;
mod spline;
mod state;

pub use contact::SurfaceSpec;
pub use continuum::Precision;
pub use state::MpmState;

/// Most substeps of a control step.
const SUBSTEPS: f64 = 100_000.0;

/// Config of [`MpmModel`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MpmSpec {
    /// Distance Δ of two grid nodes, about that of two particles \[m\].
    #[schemars(range(min = 1e-6))]
    pub cell: f64,
    /// Share of a cell that sound crosses in a substep, at most \[1\].
    #[schemars(range(min = 1e-3, max = 1.0))]
    pub courant: f64,
    /// Density ρ \[kg/m³\].
    #[schemars(range(min = 1e-3))]
    pub density: f64,
    /// Young's modulus E \[Pa\].
    #[schemars(range(min = 1e-3))]
    pub young_modulus: f64,
    /// Poisson's ratio ν \[1\].
    #[schemars(range(min = 0.0, max = 0.499))]
    pub poisson_ratio: f64,
    /// Shear stress at which the material flows, `|dev τ|` \[Pa\].
    #[schemars(range(min = 0.0))]
    pub yield_stress: f64,
    /// Viscosity η \[Pa s\].
    #[schemars(range(min = 0.0))]
    pub viscosity: f64,
    /// Acceleration of gravity g, downward \[m/s²\].
    #[schemars(range(min = 0.0))]
    pub gravity: f64,
    /// How the table and the walls hold what touches them.
    pub table: SurfaceSpec,
    /// How the tool does.
    pub tool: SurfaceSpec,
    /// Distance ℓ over which the tool's hold fades outside of it \[m\].
    #[schemars(range(min = 1e-6))]
    pub softness: f64,
    /// Numbers that a step is computed in.
    #[serde(default, skip_serializing_if = "Precision::is_default")]
    pub precision: Precision,
    /// Which states of a rollout its gradient keeps.
    #[serde(default, skip_serializing_if = "Checkpoints::is_default")]
    pub checkpoints: Checkpoints,
}

impl MpmSpec {
    pub(crate) fn build(self) -> anyhow::Result<MpmModel> {
        MpmModel::new(self)
    }

    /// # Errors
    /// When a value is impossible.
    fn check(&self) -> anyhow::Result<()> {
        let positive = [
            ("cell", self.cell),
            ("courant", self.courant),
            ("density", self.density),
            ("young_modulus", self.young_modulus),
            ("softness", self.softness),
        ];
        for (key, value) in positive {
            ensure!(value > 0.0 && value.is_finite(), "dynamics.{key} must be positive and finite, got {value}");
        }
        ensure!(self.courant <= 1.0, "dynamics.courant must be at most 1, got {}", self.courant);
        let friction = |surface: &SurfaceSpec| match surface {
            SurfaceSpec::Sticky {} => 0.0,
            SurfaceSpec::Coulomb { friction } => *friction,
        };
        let not_negative = [
            ("yield_stress", self.yield_stress),
            ("viscosity", self.viscosity),
            ("gravity", self.gravity),
            ("table.friction", friction(&self.table)),
            ("tool.friction", friction(&self.tool)),
        ];
        for (key, value) in not_negative {
            ensure!(value >= 0.0 && value.is_finite(), "dynamics.{key} must be at least 0 and finite, got {value}");
        }
        let nu = self.poisson_ratio;
        ensure!((0.0..0.5).contains(&nu), "dynamics.poisson_ratio must lie in [0, 0.5), got {nu}");
        Ok(())
    }
}

/// A model that moves particles as material points of one elastoplastic body.
pub struct MpmModel {
    cell: f64,
    /// Substeps that a second needs \[1/s\].
    rate: f64,
    gravity: f64,
    table: SurfaceSpec,
    tool: SurfaceSpec,
    softness: f64,
    continuum: Box<dyn Stepping>,
    checkpoints: Checkpoints,
}

impl MpmModel {
    /// A model of these constants.
    ///
    /// # Errors
    /// A sentence naming the key whose value is impossible.
    pub fn new(spec: MpmSpec) -> anyhow::Result<Self> {
        spec.check()?;
        let nu = spec.poisson_ratio;
        let stiffness = spec.young_modulus / spec.density;
        let shear = stiffness / (2.0 * (1.0 + nu));
        let material = Material {
            shear,
            lame: stiffness * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)),
            yields: spec.yield_stress / spec.density / (2.0 * shear),
        };
        let viscosity = spec.viscosity / spec.density;
        let sound = (material.lame + 2.0 * material.shear).sqrt();
        let rate = (sound + 4.0 * viscosity / spec.cell) / (spec.courant * spec.cell);
        let continuum = spec.precision.continuum(&material, viscosity);
        let MpmSpec { cell, gravity, table, tool, softness, checkpoints, .. } = spec;
        Ok(Self { cell, rate, gravity, table, tool, softness, continuum, checkpoints })
    }

    /// K of a control step of `interval` \[s\].
    pub fn substeps(&self, interval: f64) -> usize {
        (self.rate * interval).ceil().clamp(1.0, SUBSTEPS) as usize
    }
}

impl Dynamics for MpmModel {
    type State = MpmState;

    fn accepts(&self, scene: &Scene) -> anyhow::Result<()> {
        scene.check()?;
        let needed = self.rate * scene.interval;
        ensure!(
            needed <= SUBSTEPS,
            "a control step of {} s would take {needed:.0} substeps: the material is too stiff or too viscous for such cells; lower \
             dynamics.young_modulus or dynamics.viscosity, or raise dynamics.density or dynamics.cell",
            scene.interval
        );
        Ok(())
    }

    fn encode(&self, scene: &Scene) -> MpmState {
        MpmState::new(scene)
    }

    fn step(&self, state: &MpmState, control: &Control) -> MpmState {
        state.next(self.continuum.step(self, state, control), control)
    }

    fn decode(&self, state: &MpmState) -> Particles {
        state.decode()
    }

    fn checkpoints(&self) -> Checkpoints {
        self.checkpoints
    }

    fn adjoint(&self) -> Option<&dyn Adjoint<MpmState>> {
        Some(self)
    }
}
