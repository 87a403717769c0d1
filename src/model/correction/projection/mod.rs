//! A prediction moved, as little as possible, to where physics allows.
use super::{Correction, Outcome, OutcomeGrad};
use crate::model::placed::Placed;
use crate::state::{Particles, ParticlesGrad};
use allowed::Allowed;
use anyhow::ensure;
use glam::DVec3;
use program::{Program, Solution};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

mod allowed;
mod constraint;
mod program;

/// Config of [`Projection`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ProjectedSpec {
    /// Least distance of a particle's centre from the tool, the table and walls; negative where their skin may be entered \[m\].
    pub clearance: f64,
    /// Least distance of two particles' centres \[m\].
    #[schemars(range(min = 1e-6))]
    pub diameter: f64,
    /// Distance below which two particles hold together over a control step \[m\].
    #[schemars(range(min = 0.0))]
    pub bond: f64,
    /// Most that such a pair may part in a control step, as a fraction of its distance and at least of the diameter \[1\].
    #[schemars(range(min = 0.0))]
    pub stretch: f64,
    /// Most that one constraint may push a particle \[m\]: where constraints contradict each other, such as in a gap closed below a
    /// diameter, they give way.
    #[schemars(range(min = 1e-6))]
    pub limit: f64,
}

impl ProjectedSpec {
    /// The correction.
    ///
    /// # Errors
    /// A sentence naming the impossible key.
    pub fn build(self) -> anyhow::Result<Projection> {
        for (key, value) in [("diameter", self.diameter), ("limit", self.limit)] {
            ensure!(value > 0.0 && value.is_finite(), "{key} of the projection must be a positive length, got {value}");
        }
        for (key, value) in [("bond", self.bond), ("stretch", self.stretch)] {
            let possible = value >= 0.0 && value.is_finite();
            ensure!(possible, "{key} of the projection must be at least 0 and finite, got {value}");
        }
        let clearance = self.clearance;
        let reaches = clearance.is_finite() && clearance + self.limit > 0.0;
        ensure!(reaches, "clearance of the projection must be finite and above -limit, got {clearance}");
        Ok(Projection(self))
    }
}

/// `x' = argmin ½ Σ |x'ᵢ − x̂ᵢ|² + limit Σ_k max(0, g_k(x'))`, `v' = v̂ + (x' − x̂)/Δt` of the prediction (x̂, v̂): a convex quadratic
/// program, with second-order cones for stretch, with one constraint `g_k ≤ 0` for every
///
/// - particle and plane: `n·x ≥ offset + clearance`,
/// - particle and tool part: `d(x̂) + ∇d(x̂)·(x − x̂) ≥ clearance`, which for a convex part implies `d(x) ≥ clearance`,
/// - pair of particles: `n·(xᵢ − xⱼ) ≥ diameter` along their predicted line of centres n, which implies `|xᵢ − xⱼ| ≥ diameter`,
/// - pair nearer than `bond` at the start of the step: `|xᵢ − xⱼ| ≤ (1 + stretch) max(|xᵢ − xⱼ| at the start, diameter)`.
///
/// Constraints enter when the prediction, or a solution without them, violates them; where none is, nothing is solved and the
/// prediction stands bit by bit. A constraint whose multiplier stays below `limit` holds exactly (ℓ₁ penalties
/// are exact, Nocedal & Wright 2006, th. 17.3). The derivative is that of the solution's optimality conditions with its active set
/// (Amos & Kolter 2017, eq. 6). A step whose program finds no solution has NaN for positions.
pub struct Projection(ProjectedSpec);

/// Most times that constraints are added to a program.
const ROUNDS: usize = 30;

impl Projection {
    /// The program of an outcome and its solution, or `None` where the prediction is allowed.
    fn solve<'a>(&'a self, outcome: &'a Outcome<'a>, parts: &'a [Placed<'a>]) -> Option<(Program<'a>, Solution)> {
        let predicted = &outcome.predicted.positions[..];
        let mut allowed = Allowed::new(&self.0, &outcome.before, predicted, parts);
        let mut program = Program::new(predicted, self.0.diameter, self.0.limit);
        let mut solution: Option<Solution> = None;
        for _ in 0..ROUNDS {
            let added = allowed.violated(solution.as_ref().map_or(predicted, |found| &found.positions));
            if added.is_empty() {
                break;
            }
            program.extend(added);
            solution = Some(program.solve());
        }
        solution.map(|solution| (program, solution))
    }
}

impl Correction for Projection {
    fn correct(&self, outcome: &Outcome<'_>) -> Particles {
        let parts = Allowed::parts(&self.0, &outcome.before);
        let Some((_, Solution { positions, .. })) = self.solve(outcome, &parts) else {
            return outcome.predicted.clone();
        };
        let mut velocities = outcome.predicted.velocities.clone();
        for (v, (to, from)) in velocities.iter_mut().zip(positions.iter().zip(&outcome.predicted.positions)) {
            *v += (*to - *from) / outcome.before.interval;
        }
        Particles { positions, velocities }
    }

    fn correct_vjp(&self, outcome: &Outcome<'_>, at: &ParticlesGrad, grad: &mut OutcomeGrad<'_>) {
        let parts = Allowed::parts(&self.0, &outcome.before);
        let OutcomeGrad { before, predicted } = grad;
        let add = |sum: &mut [DVec3], rows: &[DVec3]| sum.iter_mut().zip(rows).for_each(|(sum, row)| *sum += *row);
        add(&mut predicted.velocities, &at.velocities);
        let Some((program, solution)) = self.solve(outcome, &parts) else {
            return add(&mut predicted.positions, &at.positions);
        };
        let per_step = outcome.before.interval.recip();
        let rows = at.positions.iter().zip(&at.velocities);
        let by_positions: Vec<DVec3> = rows.map(|(x, v)| *x + per_step * *v).collect();
        predicted.positions.iter_mut().zip(&at.velocities).for_each(|(sum, v)| *sum -= per_step * *v);
        let adjoint = program.adjoint(&solution, &by_positions);
        add(&mut predicted.positions, &adjoint.positions);
        // What constraints add: to the prediction, where the tool's touches add to the view's particles, and to the start.
        let start = std::mem::take(&mut before.particles);
        before.particles = std::mem::take(predicted);
        let mut by_start = start.positions;
        for (k, constraint) in program.constraints().enumerate() {
            let pull = adjoint.pull(k, &solution);
            constraint.pull(&pull, &outcome.predicted.positions, before, &mut by_start);
        }
        *predicted = std::mem::take(&mut before.particles);
        before.particles = ParticlesGrad { positions: by_start, velocities: start.velocities };
    }
}
