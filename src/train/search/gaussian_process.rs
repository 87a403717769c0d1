//! A Gaussian process over the unit box: what a few costs say about all others.
use super::cholesky::Cholesky;
use statrs::function::erf::erfc;
use std::f64::consts::{PI, SQRT_2};

/// Lengths that one coordinate may have.
const LENGTHS: [f64; 7] = [0.05, 0.1, 0.2, 0.4, 0.8, 1.6, 6.4];
/// Variance beside that of the values: costs have no noise, but the matrix must have a factor.
const JITTER: f64 = 1e-8;

/// Matérn-5/2 with a length for each coordinate (Rasmussen & Williams 2006, eq. 4.17 and 2.25):
/// `k = (1 + √5 ρ + 5/3 ρ²) e^{−√5 ρ}`, `ρ² = Σ (xₖ − yₖ)²/ℓₖ²`; values are centred and scaled.
pub struct GaussianProcess {
    points: Vec<Vec<f64>>,
    lengths: Vec<f64>,
    factor: Cholesky,
    /// `K⁻¹ y`.
    weights: Vec<f64>,
    mean: f64,
    deviation: f64,
}

impl GaussianProcess {
    /// Through `values` at `points`, with lengths that make them likely, looked for from `lengths` on, a coordinate at a time.
    pub fn new(points: Vec<Vec<f64>>, values: &[f64], lengths: Vec<f64>) -> Self {
        let mut lengths = lengths;
        let scaled = scaled(values);
        let mut best = likelihood(&points, &scaled.0, &lengths);
        for k in 0..lengths.len() {
            for length in LENGTHS {
                let mut other = lengths.clone();
                other[k] = length;
                let found = likelihood(&points, &scaled.0, &other);
                if found > best {
                    (best, lengths) = (found, other);
                }
            }
        }
        Self::with(points, values, lengths)
    }

    /// Through `values` at `points`, with these lengths.
    pub fn with(points: Vec<Vec<f64>>, values: &[f64], lengths: Vec<f64>) -> Self {
        let (values, mean, deviation) = scaled(values);
        let factor = factor(&points, &lengths);
        let weights = factor.backward(factor.forward(&values));
        Self { points, lengths, factor, weights, mean, deviation }
    }

    /// The lengths.
    pub fn lengths(&self) -> &[f64] {
        &self.lengths
    }

    /// Mean and standard deviation at `point`.
    pub fn predict(&self, point: &[f64]) -> (f64, f64) {
        let near: Vec<f64> = self.points.iter().map(|p| kernel(p, point, &self.lengths)).collect();
        let mean: f64 = near.iter().zip(&self.weights).map(|(k, w)| k * w).sum();
        let known: f64 = self.factor.forward(&near).iter().map(|x| x * x).sum();
        (self.mean + self.deviation * mean, self.deviation * (1.0 - known).max(0.0).sqrt())
    }
}

/// `E[max(0, best − y)]` for y of this mean and deviation: `(best − m) Φ(z) + s φ(z)`, `z = (best − m)/s`
/// (Jones, Schonlau & Welch 1998, eq. 15).
pub fn expected_improvement(mean: f64, deviation: f64, best: f64) -> f64 {
    let gain = best - mean;
    if deviation <= 0.0 {
        return gain.max(0.0);
    }
    let z = gain / deviation;
    let below = 0.5 * erfc(-z / SQRT_2);
    gain * below + deviation * (-0.5 * z * z).exp() / (2.0 * PI).sqrt()
}

fn kernel(a: &[f64], b: &[f64], lengths: &[f64]) -> f64 {
    let square: f64 = a.iter().zip(b).zip(lengths).map(|((a, b), l)| ((a - b) / l).powi(2)).sum();
    let far = (5.0 * square).sqrt();
    (1.0 + far + far * far / 3.0) * (-far).exp()
}

fn factor(points: &[Vec<f64>], lengths: &[f64]) -> Cholesky {
    let attempt = |jitter: f64| {
        let entry = |i: usize, j: usize| kernel(&points[i], &points[j], lengths) + if i == j { jitter } else { 0.0 };
        Cholesky::new(points.len(), entry)
    };
    // Points that almost coincide need more.
    let jitters = (0..).map(|k| JITTER * 10_f64.powi(k));
    jitters.into_iter().find_map(attempt).expect("a matrix with a large enough diagonal has a factor")
}

/// `ln p(y)` but for a constant, the scale of y taken out by its own maximum: `−½ n ln(yᵀ K⁻¹ y / n) − ½ ln det K`.
fn likelihood(points: &[Vec<f64>], values: &[f64], lengths: &[f64]) -> f64 {
    let factor = factor(points, lengths);
    let count = values.len() as f64;
    let square: f64 = factor.forward(values).iter().map(|x| x * x).sum();
    -0.5 * count * (square / count).max(f64::MIN_POSITIVE).ln() - 0.5 * factor.log_determinant()
}

/// Values with mean 0 and deviation 1, and what they were.
fn scaled(values: &[f64]) -> (Vec<f64>, f64, f64) {
    let count = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / count;
    let deviation = (values.iter().map(|y| (y - mean).powi(2)).sum::<f64>() / count).sqrt();
    let deviation = if deviation > 0.0 { deviation } else { 1.0 };
    (values.iter().map(|y| (y - mean) / deviation).collect(), mean, deviation)
}
