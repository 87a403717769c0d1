//! The activation.

/// Mean of `(x + √(x² + 1))/2` over a standard normal x.
const MEAN: f32 = 0.677_265_4;

/// `σ(x) = (x + √(x² + 1))/2 − E`: squareplus (Barron 2021, eq. 1, b = 1) less its mean, so that sums over many neighbours
/// do not drift; smooth everywhere and free of exponentials.
#[inline(always)]
pub(super) fn squareplus(x: f32) -> f32 {
    0.5 * (x + (x * x + 1.0).sqrt()) - MEAN
}

/// `σ'(x)` from `σ(x)`: with `y = σ + E`, `σ' = y²/(y² + ¼)`.
#[inline(always)]
pub(super) fn slope(value: f32) -> f32 {
    let y = value + MEAN;
    let square = y * y;
    square / (square + 0.25)
}

/// The same in f64.
pub(super) mod double {
    const MEAN: f64 = super::MEAN as f64;

    #[inline(always)]
    pub(in crate::model::net) fn squareplus(x: f64) -> f64 {
        0.5 * (x + (x * x + 1.0).sqrt()) - MEAN
    }

    #[inline(always)]
    pub(in crate::model::net) fn slope(value: f64) -> f64 {
        let square = (value + MEAN).powi(2);
        square / (square + 0.25)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slope_is_the_derivative_and_the_mean_is_zero() {
        for i in -40..40 {
            let x = f64::from(i) * 0.13;
            let exact = 0.5 * (1.0 + x / (x * x + 1.0).sqrt());
            assert!((f64::from(slope(squareplus(x as f32))) - exact).abs() < 2e-6, "at {x}");
        }
        let weight = |x: f64| (-0.5 * x * x).exp();
        let grid = || (-8000..8000).map(|i| f64::from(i) * 1e-3);
        let mean =
            grid().map(|x| weight(x) * f64::from(squareplus(x as f32))).sum::<f64>() / grid().map(weight).sum::<f64>();
        assert!(mean.abs() < 1e-6, "{mean}");
    }
}
