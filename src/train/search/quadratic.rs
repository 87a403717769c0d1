//! Convex quadratic programs in a box, by an interior point method.
use super::cholesky::Cholesky;
use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};

/// Bounds that are so many times as far as the least are none: larger numbers spoil the solver's.
const FAR: f64 = 1e6;

/// The least of `½ dᵀ H d + gᵀ d` over `low ≤ d ≤ high`; H is symmetric, positive semidefinite and given row by row.
///
/// # Errors
/// When the program has no solution to the solver's precision, as with numbers that are not finite.
pub fn least_in_box(hessian: &[f64], slope: &[f64], room: &[[f64; 2]]) -> anyhow::Result<Vec<f64>> {
    let count = slope.len();
    if slope.iter().all(|g| *g == 0.0) {
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
    let signs = (0..2 * count).map(|row| if row < count { 1.0 } else { -1.0 }).collect();
    let columns = (0..2 * count).map(|row| row % count).collect();
    let sides = CscMatrix::new_from_triplets(2 * count, count, (0..2 * count).collect(), columns, signs);
    let scaled = |k: usize, side: usize| room[k][side] / (unit[k] * size);
    let limits: Vec<f64> = (0..count).map(|k| scaled(k, 1)).chain((0..count).map(|k| -scaled(k, 0))).collect();
    let limits: Vec<f64> = limits.into_iter().map(|limit| limit.min(FAR)).collect();
    let settings = DefaultSettings {
        verbose: false,
        tol_gap_abs: 1e-12,
        tol_gap_rel: 1e-12,
        tol_feas: 1e-12,
        ..DefaultSettings::default()
    };
    let cones = [SupportedConeT::NonnegativeConeT(2 * count)];
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
