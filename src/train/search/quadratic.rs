//! Convex quadratic programs in a box and in cones, by an interior point method.
use super::cholesky::Cholesky;
use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};

/// Bounds that are so many times as far as the least are none: larger numbers spoil the solver's.
const FAR: f64 = 1e6;

/// The least of `½ dᵀ H d + gᵀ d` over `low ≤ d ≤ high` and every cone `|(b₁(1 + d_i₁), …)| ≤ b₀(1 + d_i₀)`, given by its (i, b); H is
/// symmetric, positive semidefinite and given row by row.
///
/// # Errors
/// When the program has no solution to the solver's precision, as with numbers that are not finite.
pub fn least_within(
    hessian: &[f64],
    slope: &[f64],
    room: &[[f64; 2]],
    cones: &[Vec<(usize, f64)>],
) -> anyhow::Result<Vec<f64>> {
    let count = slope.len();
    if slope.iter().all(|g| *g == 0.0) && cones.is_empty() {
        return Ok(vec![0.0; count]);
    }
    // In units of each unknown's own curvature, so that steep and flat ones weigh alike, and of the solution's size.
    let own = |k: usize| hessian[k * count + k];
    let unit: Vec<f64> = (0..count).map(|k| if own(k) > 0.0 { own(k).sqrt().recip() } else { 1.0 }).collect();
    let entry = |i: usize, j: usize| 0.5 * (hessian[i * count + j] + hessian[j * count + i]) * unit[i] * unit[j];
    let linear: Vec<f64> = slope.iter().zip(&unit).map(|(g, s)| g * s).collect();
    let free = Cholesky::new(count, entry).map(|factor| factor.backward(factor.forward(&linear)));
    let free = free.unwrap_or_else(|| linear.clone());
    let inside = free.iter().zip(&unit).zip(room).map(|((x, s), [low, high])| (-x).clamp(low / s, high / s).abs());
    let size = inside.fold(f64::MIN_POSITIVE.sqrt(), f64::max);

    let upper: Vec<(usize, usize)> = (0..count).flat_map(|j| (0..=j).map(move |i| (i, j))).collect();
    let (rows, columns): (Vec<usize>, Vec<usize>) = upper.iter().copied().unzip();
    let entries = upper.iter().map(|(i, j)| entry(*i, *j)).collect();
    let curvature = CscMatrix::new_from_triplets(count, count, rows, columns, entries);
    let linear: Vec<f64> = linear.iter().map(|g| g / size).collect();
    let scaled = |k: usize, side: usize| room[k][side] / (unit[k] * size);
    let sides = (0..count).map(|k| (k, 1.0, scaled(k, 1))).chain((0..count).map(|k| (k, -1.0, -scaled(k, 0))));
    let sides = sides.map(|(column, sign, limit)| (column, sign, limit.min(FAR)));
    // The solver's rows are `b − A x`; any unit will do for a whole cone.
    let curved = cones.iter().flatten().map(|(column, b)| (*column, -b * unit[*column], b / size));
    let all: Vec<(usize, f64, f64)> = sides.chain(curved).collect();
    let (columns, values) = all.iter().map(|(column, value, _)| (*column, *value)).unzip();
    let limits: Vec<f64> = all.iter().map(|(.., limit)| *limit).collect();
    let sides = CscMatrix::new_from_triplets(all.len(), count, (0..all.len()).collect(), columns, values);
    let settings = DefaultSettings {
        verbose: false,
        tol_gap_abs: 1e-12,
        tol_gap_rel: 1e-12,
        tol_feas: 1e-12,
        ..DefaultSettings::default()
    };
    let curved = cones.iter().map(|cone| SupportedConeT::SecondOrderConeT(cone.len()));
    let cones: Vec<_> = std::iter::once(SupportedConeT::NonnegativeConeT(2 * count)).chain(curved).collect();
    let mut solver = DefaultSolver::new(&curvature, &linear, &sides, &limits, &cones, settings)
        .map_err(|error| anyhow::anyhow!("the least squares cannot be set up: {error}"))?;
    solver.solve();
    let status = solver.solution.status;
    anyhow::ensure!(
        matches!(status, SolverStatus::Solved | SolverStatus::AlmostSolved | SolverStatus::InsufficientProgress),
        "the least squares cannot be solved: {status:?}"
    );
    let found = solver.solution.x.iter().zip(&unit).zip(room);
    Ok(found.map(|((x, s), [low, high])| (x * s * size).clamp(*low, *high)).collect())
}
