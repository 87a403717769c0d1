//! A power as products, one root and one reciprocal.
use super::rational::Rational;

/// How xᵖ is computed: x^whole · x^fraction, the reciprocal of that if `inverse`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Chain {
    /// `whole` factors x, and √x or ⁴√x to the power of 1 or 3.
    Roots { whole: u32, quarters: u32, inverse: Inverse },
    /// A call of `powf`.
    General(f64),
}

/// Whether a power is turned over at its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Inverse {
    /// No.
    Not,
    /// Yes.
    Last,
}

/// Of xᵖ.
pub(super) fn chain(exponent: Rational) -> Chain {
    let (numerator, denominator) = exponent.parts();
    let inverse = if numerator < 0 { Inverse::Last } else { Inverse::Not };
    match (numerator.unsigned_abs(), denominator) {
        (n, 1 | 2 | 4) if n <= 64 => {
            let quarters = n as u32 * (4 / denominator as u32);
            Chain::Roots { whole: quarters / 4, quarters: quarters % 4, inverse }
        }
        _ => Chain::General(exponent.value()),
    }
}

/// Products that xⁿ takes by squaring.
fn products(n: u32) -> u32 {
    if n == 0 { 0 } else { n.ilog2() + n.count_ones() - 1 }
}

/// Number of operations of xᵖ, and their cost in additions.
pub(super) fn price(exponent: Rational) -> (u32, f64) {
    match chain(exponent) {
        Chain::General(_) => (1, 40.0),
        Chain::Roots { whole, quarters, inverse } => {
            // A root, the root of that, and the product of both.
            let (roots, between) = [(0, 0), (2, 0), (1, 0), (2, 1)][quarters as usize];
            let joined = u32::from(whole > 0 && quarters > 0);
            let multiplied = products(whole) + between + joined;
            let inverted = u32::from(inverse == Inverse::Last);
            (multiplied + roots + inverted, f64::from(multiplied) + 4.0 * f64::from(roots + inverted))
        }
    }
}
