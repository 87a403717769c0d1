//! Where a constant lies between its bounds.

/// A constant's place between its bounds on a logarithmic scale, `u = ln(c/low) / ln(high/low)`.
pub fn place(constant: f64, [low, high]: [f64; 2]) -> f64 {
    (constant.clamp(low, high) / low).ln() / (high / low).ln()
}

/// The constant at place `u`.
pub fn at(u: f64, [low, high]: [f64; 2]) -> f64 {
    (low * (high / low).powf(u)).clamp(low, high)
}
