//! Where a constant lies between its bounds.

/// A constant's place between its bounds on a logarithmic scale, `u = ln(c/low) / ln(high/low)`.
pub fn place(constant: f64, [low, high]: [f64; 2]) -> f64 {
    (constant.clamp(low, high) / low).ln() / (high / low).ln()
}

/// The constants at a point of the unit box.
pub fn constants(point: &[f64], bounds: &[[f64; 2]]) -> Vec<f64> {
    point.iter().zip(bounds).map(|(u, bounds)| at(*u, *bounds)).collect()
}

/// The constant at place `u`.
pub fn at(u: f64, [low, high]: [f64; 2]) -> f64 {
    (low * (high / low).powf(u)).clamp(low, high)
}
