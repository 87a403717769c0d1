//! The rotation that lays one list of vectors over another, and its derivative.
use glam::{DMat3, DQuat, DVec3};
use nalgebra::Matrix4;

/// The rotation of least `Σ |R aᵢ − bᵢ|²` over pairs (a, b) of vectors (Kabsch 1976; in quaternions by Horn 1987).
pub fn rotation_between(pairs: impl Iterator<Item = (DVec3, DVec3)>) -> DQuat {
    // Horn's matrix: qᵀ N q = Σ bᵢ · (q aᵢ q*), for q = (w, x, y, z).
    let mut sums = Matrix4::zeros();
    for (a, b) in pairs {
        let (dot, cross) = (a.dot(b), a.cross(b));
        let (a, b) = (a.to_array(), b.to_array());
        sums[(0, 0)] += dot;
        for i in 0..3 {
            sums[(0, i + 1)] += cross[i];
            sums[(i + 1, 0)] += cross[i];
            for j in 0..3 {
                sums[(i + 1, j + 1)] += a[i] * b[j] + a[j] * b[i] - if i == j { dot } else { 0.0 };
            }
        }
    }
    let eigen = sums.symmetric_eigen();
    let q = eigen.eigenvectors.column(eigen.eigenvalues.imax()).into_owned();
    DQuat::from_xyzw(q[1], q[2], q[3], q[0]).normalize()
}

/// λ of the derivative of [`rotation_between`] in direction `turn`: for pairs (p, b) of turned vectors `p = R a` and their targets,
/// `∂(turn·ω)/∂bᵢ = λ × pᵢ` and `∂(turn·ω)/∂pᵢ = bᵢ × λ` at fixed R, where R moves along `exp(ω) R`.
///
/// The best rotation has `Σ pᵢ × bᵢ = 0`; differentiated, `(tr S − S) ω = Σ pᵢ × δbᵢ + δpᵢ × bᵢ` with `S = Σ pᵢ bᵢᵀ`, so that
/// `λ = (tr S − S)⁻ᵀ turn`; zero where vectors on one line leave the rotation open.
pub fn rotation_between_vjp(pairs: impl Iterator<Item = (DVec3, DVec3)>, turn: DVec3) -> DVec3 {
    let mut spread = DMat3::ZERO;
    for (p, b) in pairs {
        spread += DMat3::from_cols(p * b.x, p * b.y, p * b.z);
    }
    let trace = spread.x_axis.x + spread.y_axis.y + spread.z_axis.z;
    let matrix = DMat3::from_diagonal(DVec3::splat(trace)) - spread;
    if matrix.determinant().abs() <= 1e-12 * trace.abs().powi(3) {
        return DVec3::ZERO;
    }
    matrix.transpose().inverse() * turn
}
