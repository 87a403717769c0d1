//! Convex least squares in the constants themselves, step by step where the prediction is not linear in them.
use super::place::{constants, place};
use super::quadratic::least_within;
use super::{Each, Search, Start, Tried};
use anyhow::ensure;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Config of [`LeastSquares`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct LeastSquaresSpec {
    /// Evaluations that a gradient counts for; the two rollouts a constant that the design matrix takes are counted beside it.
    #[schemars(range(min = 1))]
    pub price: usize,
}

impl Default for LeastSquaresSpec {
    fn default() -> Self {
        Self { price: 5 }
    }
}

impl LeastSquaresSpec {
    pub(crate) fn build(self) -> anyhow::Result<LeastSquares> {
        ensure!(self.price > 0, "`price` of the search is 0; give at least 1");
        Ok(LeastSquares(self))
    }
}

/// Gauss–Newton on relative changes d of the constants: `min |r + (∂r/∂d) d|² + λ Σₖ Hₖₖ dₖ²` within the bounds and cones, a convex
/// program with H the first term's curvature.
///
/// A prediction that is linear in the constants is solved for at once, λ being zero until a step fails (Levenberg 1944).
pub struct LeastSquares(LeastSquaresSpec);

/// Change of all constants below which there is nothing left to gain.
const SMALL: f64 = 1e-7;
/// λ after the first step that fails.
const DAMPED: f64 = 1e-3;
/// λ beyond which more of it is of no use.
const HEAVY: f64 = 1e6;

impl Search for LeastSquares {
    fn differentiates(&self) -> bool {
        true
    }

    fn search(&self, start: &Start, tried: &Tried<'_>, each: &mut Each<'_>) -> anyhow::Result<()> {
        let bounds = tried.bounds();
        let count = bounds.len();
        let price = 2 * count + self.0.price;
        let before = tried.spent();
        let affords = |price: usize| tried.spent() - before + price <= start.evaluations;
        let (mut point, mut damping) = (start.point.clone(), 0.0);
        while affords(price + 1) {
            let Some(here) = tried.squares(&point, price) else { return each(None) };
            let constants = constants(&point, &bounds);
            let room: Vec<[f64; 2]> = constants
                .iter()
                .zip(&bounds)
                .map(|(c, [low, high])| [(low / c - 1.0).min(0.0), (high / c - 1.0).max(0.0)])
                .collect();
            let cones: Vec<_> = tried.cones().iter().map(|cone| cone.rows(&constants)).collect();
            let next = loop {
                let mut curvature = here.curvature.clone();
                (0..count).for_each(|k| curvature[k * count + k] *= 1.0 + damping);
                // What the solver cannot solve, it can with more on the diagonal.
                let change = match least_within(&curvature, &here.slope, &room, &cones) {
                    Err(error) if damping > HEAVY => return Err(error),
                    Err(_) => {
                        damping = DAMPED.max(10.0 * damping);
                        continue;
                    }
                    Ok(change) => change,
                };
                if change.iter().all(|d| d.abs() < SMALL) || !affords(1) {
                    return each(Some(damping));
                }
                let moved = constants.iter().zip(&change).zip(&bounds);
                let next: Vec<f64> = moved.map(|((c, d), bounds)| place(c * (1.0 + d), *bounds)).collect();
                if tried.cost(&next) < here.cost {
                    break next;
                }
                damping = DAMPED.max(10.0 * damping);
            };
            point = next;
            damping = if damping > DAMPED { 0.1 * damping } else { 0.0 };
            each(Some(damping))?;
        }
        Ok(())
    }
}
