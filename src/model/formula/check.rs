//! Whether two sets of expressions agree: a simplified program is believed only after a thousand points.
use super::expression::{Expressions, Id};
use super::interval::Interval;
use super::program::Program;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Points at which a simplified program must agree.
pub const POINTS: usize = 1024;
/// Draws among which they are looked for; where formulas have no value, there is nothing to compare.
const DRAWS: usize = 20 * POINTS;
/// Greatest difference as a fraction of an output, and beside it in units of what rounding may have done to the plain formula.
const TOLERANCE: f64 = 1e-10;
const ROUNDING: f64 = 4096.0 * f64::EPSILON;

/// What came of the check.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// They agreed at this many points; elsewhere both had no value.
    Agrees {
        /// Number of points.
        points: usize,
    },
    /// They are not shown to agree: a sentence that says why. The unsimplified program is used.
    Kept(String),
}

/// Compares the expressions `plain`, evaluated node by node, with the compiled `program` at points drawn in the ranges of
/// [`Expressions::names`].
pub(super) fn check(
    expressions: &Expressions,
    plain: &[Id],
    program: &Program,
    inputs: &[u32],
    ranges: &[Interval],
) -> Verdict {
    let mut rng = ChaCha8Rng::seed_from_u64(u64::from_le_bytes(*b"formulas"));
    let (mut arrays, mut expected, mut rounding) = (vec![Vec::new(); inputs.len()], Vec::new(), Vec::new());
    for _ in 0..DRAWS {
        let point: Vec<f64> = ranges.iter().map(|range| draw(*range, &mut rng)).collect();
        let values = expressions.evaluate(plain, &point);
        let errors = expressions.rounding(plain, &point);
        // Where rounding knows no bound, as at the root of zero, the plain value tells nothing.
        if values.iter().chain(&errors).all(|value| value.is_finite()) {
            inputs.iter().zip(&mut arrays).for_each(|(name, array)| array.push(point[*name as usize]));
            rounding.push(errors);
            expected.push(values);
        }
        if expected.len() == POINTS {
            break;
        }
    }
    if expected.len() < POINTS.min(1000) {
        return Verdict::Kept(format!(
            "the formula has a value at {} of {DRAWS} points drawn in range; narrow the ranges",
            expected.len()
        ));
    }
    let views: Vec<&[f64]> = arrays.iter().map(Vec::as_slice).collect();
    let found = program.evaluate(expected.len(), &views);
    for (output, found) in found.iter().enumerate() {
        for (at, (values, found)) in expected.iter().zip(found).enumerate() {
            let plain = values[output];
            let gap = (found - plain).abs();
            if gap.is_nan() || gap > TOLERANCE * plain.abs() + ROUNDING * rounding[at][output] {
                let place: Vec<String> = inputs
                    .iter()
                    .zip(&arrays)
                    .map(|(name, array)| format!("{} = {:e}", expressions.names()[*name as usize], array[at]))
                    .collect();
                return Verdict::Kept(format!(
                    "at {} the simplified form of output {output} is {found:e}, not {plain:e}",
                    place.join(", ")
                ));
            }
        }
    }
    Verdict::Agrees { points: expected.len() }
}

/// A number of the range: uniform between finite ends, a quarter of them close to one; over many orders of magnitude otherwise.
fn draw(range: Interval, rng: &mut ChaCha8Rng) -> f64 {
    let (low, high) = (range.low.at, range.high.at);
    if let Some(point) = range.point() {
        return point;
    }
    let far = 10f64.powf(rng.random_range(-4.0..4.0));
    match (low.is_finite(), high.is_finite()) {
        (true, true) => {
            let near = match rng.random_range(0..8) {
                0 => 10f64.powf(rng.random_range(-9.0..0.0)),
                1 => 1.0 - 10f64.powf(rng.random_range(-9.0..0.0)),
                _ => rng.random::<f64>(),
            };
            low + (high - low) * near
        }
        (true, false) => low + far,
        (false, true) => high - far,
        (false, false) if rng.random::<bool>() => far,
        (false, false) => -far,
    }
}
