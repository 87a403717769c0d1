//! The covariance that a cost's Hessian asks for.
use anyhow::ensure;
use nalgebra::{DMatrix, SymmetricEigen};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What keeps directions without curvature from being searched without bound.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum FloorSpec {
    /// δ as a share of the eigenvalues' range: the same whatever the cost's unit.
    Relative {
        /// The share.
        share: f64,
    },
    /// δ itself, as CoVO-MPC's own code has it.
    Absolute {
        /// δ, in the cost's unit.
        value: f64,
    },
}

impl FloorSpec {
    pub(super) fn check(&self) -> anyhow::Result<()> {
        let (key, value) = match self {
            Self::Relative { share } => ("share", share),
            Self::Absolute { value } => ("value", value),
        };
        ensure!(*value > 0.0 && value.is_finite(), "planner.floor.{key} must be positive, got {value}");
        Ok(())
    }
}

/// A square root of Σ: samples are `μ + V diag(d) ε` with ε standard normal.
#[derive(Clone, Debug)]
pub struct Covariance {
    axes: DMatrix<f64>,
    deviations: Vec<f64>,
}

impl Covariance {
    /// `Σ = V diag(s) Vᵀ`, `s ∝ (o − min o + δ)^{-1/2}`, `log det Σ = 2 D log σ`, where `R = V diag(o) Vᵀ` is the symmetric part of
    /// `hessian`, (D, D) row-major (Yi et al. 2024, CoVO-MPC, theorem 2). Equal eigenvalues, or a Hessian that is not finite,
    /// give `σ² I`.
    pub fn of(hessian: &[f64], sigma: f64, floor: &FloorSpec) -> Self {
        let dimension = hessian.len().isqrt();
        assert_eq!(dimension * dimension, hessian.len(), "a Hessian is square");
        let isotropic = Self { axes: DMatrix::identity(dimension, dimension), deviations: vec![sigma; dimension] };
        if !hessian.iter().all(|h| h.is_finite()) {
            return isotropic;
        }
        let given = DMatrix::from_row_slice(dimension, dimension, hessian);
        let SymmetricEigen { eigenvalues, eigenvectors } = ((&given + given.transpose()) / 2.0).symmetric_eigen();
        let (low, high) = (eigenvalues.min(), eigenvalues.max());
        // Differences at the level of rounding say nothing of directions.
        if high - low <= 1e-12 * high.abs().max(low.abs()) {
            return isotropic;
        }
        let delta = match floor {
            FloorSpec::Relative { share } => share * (high - low),
            FloorSpec::Absolute { value } => *value,
        };
        let logs: Vec<f64> = eigenvalues.iter().map(|o| -0.5 * (o - low + delta).ln()).collect();
        let mean = logs.iter().sum::<f64>() / dimension as f64;
        let deviations = logs.iter().map(|log| sigma * (0.5 * (log - mean)).exp()).collect();
        Self { axes: eigenvectors, deviations }
    }

    /// `V diag(d) ε`.
    pub fn colour(&self, noise: &[f64]) -> Vec<f64> {
        let scaled: Vec<f64> = noise.iter().zip(&self.deviations).map(|(e, d)| d * e).collect();
        (0..noise.len()).map(|row| (0..noise.len()).map(|k| self.axes[(row, k)] * scaled[k]).sum()).collect()
    }

    /// `log det Σ`.
    pub fn log_determinant(&self) -> f64 {
        self.deviations.iter().map(|d| 2.0 * d.ln()).sum()
    }
}
