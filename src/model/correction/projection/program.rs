//! The convex program of a projection, solved by Clarabel, and its adjoint.
use super::constraint::{Constraint, Pull};
use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};
use glam::DVec3;

/// `min ½ |y|² + ρ Σ σ` over the displacements y of the particles that constraints bind and a slack σ ≥ 0 a constraint, in units of
/// a length ℓ.
pub(super) struct Program<'a> {
    predicted: &'a [DVec3],
    /// ℓ \[m\].
    unit: f64,
    /// ρ \[m\].
    limit: f64,
    constraints: Vec<Constraint<'a>>,
    /// Particles that constraints bind.
    rows: Vec<usize>,
    /// Place of each particle among them.
    place: Vec<Option<usize>>,
}

/// Positions and multipliers.
pub(super) struct Solution {
    /// All particles \[m\].
    pub(super) positions: Vec<DVec3>,
    /// λ of each constraint \[m\].
    multipliers: Vec<f64>,
}

/// `(p, q)` of the adjoint program.
pub(super) struct Adjoint<'a> {
    constraints: &'a [Constraint<'a>],
    /// p: `∂J/∂x̂` as long as the constraints stand still.
    pub(super) positions: Vec<DVec3>,
    /// q of each constraint, zero of those that are not active.
    multipliers: Vec<f64>,
}

/// Entries of a sparse matrix.
#[derive(Default)]
struct Entries(Vec<usize>, Vec<usize>, Vec<f64>);

impl Entries {
    fn push(&mut self, row: usize, column: usize, value: f64) {
        self.0.push(row);
        self.1.push(column);
        self.2.push(value);
    }

    fn vector(&mut self, row: usize, particle: usize, value: DVec3) {
        value.to_array().into_iter().enumerate().for_each(|(k, value)| self.push(row, 3 * particle + k, value));
    }

    fn matrix(self, rows: usize, columns: usize) -> CscMatrix<f64> {
        CscMatrix::new_from_triplets(rows, columns, self.0, self.1, self.2)
    }
}

impl<'a> Program<'a> {
    /// Without constraints.
    pub(super) fn new(predicted: &'a [DVec3], unit: f64, limit: f64) -> Self {
        Self { predicted, unit, limit, constraints: Vec::new(), rows: Vec::new(), place: vec![None; predicted.len()] }
    }

    /// Adds constraints.
    pub(super) fn extend(&mut self, constraints: Vec<Constraint<'a>>) {
        for constraint in constraints {
            let (i, j) = constraint.particles();
            for particle in [Some(i), j].into_iter().flatten() {
                if self.place[particle].is_none() {
                    self.place[particle] = Some(self.rows.len());
                    self.rows.push(particle);
                }
            }
            self.constraints.push(constraint);
        }
    }

    /// The constraints.
    pub(super) fn constraints(&self) -> impl Iterator<Item = &Constraint<'a>> {
        self.constraints.iter()
    }

    /// Places of the particles that a constraint binds, with the sign in which it does.
    fn bound(&self, constraint: &Constraint<'_>) -> impl Iterator<Item = (usize, f64)> {
        let (i, j) = constraint.particles();
        let place = |particle: usize| self.place[particle].expect("what a constraint binds has a place");
        [(place(i), 1.0)].into_iter().chain(j.map(|j| (place(j), -1.0)))
    }

    /// Solves it; positions are NaN where that fails.
    pub(super) fn solve(&self) -> Solution {
        let (moving, count) = (3 * self.rows.len(), self.constraints.len());
        let columns = moving + count;
        let (mut entries, mut right) = (Entries::default(), Vec::new());
        for k in 0..count {
            entries.push(k, moving + k, -1.0);
            right.push(0.0);
        }
        let mut first = vec![0; count];
        // Straight constraints, then round ones: cones of one kind stand together.
        for (k, constraint) in self.constraints.iter().enumerate() {
            let at = constraint.of(self.predicted) / self.unit;
            let (normal, bound) = match constraint {
                Constraint::Front { normal, bound, .. } => (*normal, *bound),
                Constraint::Apart { normal, least, .. } => (*normal, *least),
                Constraint::Within { .. } => continue,
            };
            first[k] = right.len();
            self.bound(constraint).for_each(|(place, sign)| entries.vector(right.len(), place, -sign * normal));
            entries.push(right.len(), moving + k, -1.0);
            right.push(normal.dot(at) - bound / self.unit);
        }
        let mut cones = vec![SupportedConeT::NonnegativeConeT(right.len())];
        for (k, constraint) in self.constraints.iter().enumerate() {
            let Constraint::Within { most, .. } = constraint else { continue };
            first[k] = right.len();
            entries.push(right.len(), moving + k, -1.0);
            right.push(most / self.unit);
            for (axis, at) in (constraint.of(self.predicted) / self.unit).to_array().into_iter().enumerate() {
                self.bound(constraint).for_each(|(place, sign)| entries.push(right.len(), 3 * place + axis, -sign));
                right.push(at);
            }
            cones.push(SupportedConeT::SecondOrderConeT(4));
        }
        let mut hessian = Entries::default();
        (0..moving).for_each(|k| hessian.push(k, k, 1.0));
        let linear: Vec<f64> = (0..columns).map(|k| if k < moving { 0.0 } else { self.limit / self.unit }).collect();
        let constraints = entries.matrix(right.len(), columns);
        let found = run(&hessian.matrix(columns, columns), &linear, &constraints, &right, &cones);
        let mut positions = self.predicted.to_vec();
        for (y, &particle) in found.0.chunks_exact(3).zip(&self.rows) {
            positions[particle] += self.unit * DVec3::from_slice(y);
        }
        Solution { positions, multipliers: first.into_iter().map(|row| self.unit * found.1[row]).collect() }
    }

    /// With `H = I + Σ λ ∇²g` and A the rows ∇g of the active constraints: `H p + Aᵀ q = ∂J/∂x`, `A p = 0`, itself a convex program,
    /// `min ½ pᵀ H p − ∂J/∂x·p` under `A p = 0`.
    pub(super) fn adjoint(&self, solution: &Solution, at: &[DVec3]) -> Adjoint<'_> {
        let moving = 3 * self.rows.len();
        let scale = self.rows.iter().map(|&i| at[i].abs().max_element()).fold(0.0, f64::max);
        let mut adjoint = Adjoint {
            constraints: &self.constraints,
            positions: at.to_vec(),
            multipliers: vec![0.0; self.constraints.len()],
        };
        if scale == 0.0 {
            return adjoint;
        }
        let (mut entries, mut active, mut hessian) = (Entries::default(), Vec::new(), Entries::default());
        (0..moving).for_each(|k| hessian.push(k, k, 1.0));
        for (k, (constraint, &multiplier)) in self.constraints.iter().zip(&solution.multipliers).enumerate() {
            let offset = constraint.of(&solution.positions);
            let normal = constraint.slope(offset);
            if let Constraint::Within { .. } = constraint {
                let bend = multiplier / offset.length();
                let ends: Vec<_> = self.bound(constraint).collect();
                for (&(p, s), &(q, t)) in ends.iter().flat_map(|a| ends.iter().map(move |b| (a, b))) {
                    for (row, column) in (0..3).flat_map(|row| (0..3).map(move |column| (row, column))) {
                        let flat = if row == column { 1.0 } else { 0.0 };
                        // The upper triangle alone.
                        if 3 * p + row <= 3 * q + column {
                            let value = s * t * bend * (flat - normal[row] * normal[column]);
                            hessian.push(3 * p + row, 3 * q + column, value);
                        }
                    }
                }
            }
            if STRICT * self.limit < multiplier && multiplier < (1.0 - STRICT) * self.limit {
                self.bound(constraint).for_each(|(place, sign)| entries.vector(active.len(), place, sign * normal));
                active.push(k);
            }
        }
        let linear: Vec<f64> = self.rows.iter().flat_map(|&i| (-at[i] / scale).to_array()).collect();
        let constraints = entries.matrix(active.len(), moving);
        let cones = [SupportedConeT::ZeroConeT(active.len())];
        let found = run(&hessian.matrix(moving, moving), &linear, &constraints, &vec![0.0; active.len()], &cones);
        for (p, &particle) in found.0.chunks_exact(3).zip(&self.rows) {
            adjoint.positions[particle] = scale * DVec3::from_slice(p);
        }
        active.iter().zip(&found.1).for_each(|(&k, q)| adjoint.multipliers[k] = scale * q);
        adjoint
    }
}

/// Fraction of the limit by which a multiplier must differ from zero and from the limit to count as neither.
const STRICT: f64 = 1e-6;

impl Adjoint<'_> {
    /// What constraint `k` needs.
    pub(super) fn pull(&self, k: usize, solution: &Solution) -> Pull {
        let constraint = &self.constraints[k];
        Pull {
            multiplier: solution.multipliers[k],
            adjoint: self.multipliers[k],
            by: constraint.of(&self.positions),
            at: constraint.of(&solution.positions),
        }
    }
}

/// Primal and dual solution of `min ½ xᵀ P x + qᵀ x` under `b − A x` in the cones; NaN where there is none.
fn run(
    hessian: &CscMatrix<f64>,
    linear: &[f64],
    constraints: &CscMatrix<f64>,
    right: &[f64],
    cones: &[SupportedConeT<f64>],
) -> (Vec<f64>, Vec<f64>) {
    let nothing = || (vec![f64::NAN; linear.len()], vec![f64::NAN; right.len()]);
    // As accurate as can be, for derivatives; where constraints nearly contradict each other, less must do.
    for tolerance in [1e-11, 1e-9, 1e-7] {
        let settings = DefaultSettings {
            verbose: false,
            presolve_enable: false,
            tol_gap_abs: tolerance,
            tol_gap_rel: tolerance,
            tol_feas: tolerance,
            reduced_tol_gap_abs: 10.0 * tolerance,
            reduced_tol_gap_rel: 10.0 * tolerance,
            reduced_tol_feas: 10.0 * tolerance,
            ..DefaultSettings::default()
        };
        let Ok(mut solver) = DefaultSolver::new(hessian, linear, constraints, right, cones, settings) else {
            return nothing();
        };
        solver.solve();
        if let SolverStatus::Solved | SolverStatus::AlmostSolved = solver.solution.status {
            return (solver.solution.x, solver.solution.z);
        }
    }
    nothing()
}
