//! Gradient descent by Adam on the logarithms of constants.
use super::{Each, Search, Start, Tried};
use crate::train::adam::Adam;
use crate::train::schedule::rate_at;
use anyhow::ensure;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Config of [`Descent`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct DescentSpec {
    /// First length of a step along each constant, as a fraction of the logarithmic width of its bounds; it falls by half a cosine.
    #[schemars(range(min = 0.0001, max = 1.0))]
    pub rate: f64,
    /// Control steps that the derivative goes back through; the whole window where this is left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1))]
    pub truncation: Option<usize>,
    /// Evaluations that a gradient counts for.
    #[schemars(range(min = 1))]
    pub price: usize,
}

impl Default for DescentSpec {
    fn default() -> Self {
        Self { rate: 0.05, truncation: None, price: 5 }
    }
}

impl DescentSpec {
    pub(crate) fn build(self) -> anyhow::Result<Descent> {
        let Self { rate, truncation, price } = self;
        ensure!(rate > 0.0 && rate <= 1.0, "`rate` of the search is {rate}; give a number from 0 to 1");
        ensure!(truncation != Some(0), "`truncation` of the search is 0; give at least 1, or leave it out");
        ensure!(price > 0, "`price` of the search is 0; give at least 1");
        Ok(Descent(self))
    }
}

/// Adam on the places of constants, kept inside the box; where the model diverges it goes back to the best point with half the
/// rate.
pub struct Descent(DescentSpec);

/// The last rate over the first.
const LAST: f64 = 0.01;

impl Search for Descent {
    fn differentiates(&self) -> bool {
        true
    }

    fn search(&self, start: &Start, tried: &Tried<'_>, each: &mut Each<'_>) -> anyhow::Result<()> {
        let DescentSpec { rate, truncation, price } = self.0;
        let steps = (start.evaluations / price) as u64;
        let mut point: Vec<f32> = start.point.iter().map(|u| *u as f32).collect();
        let (mut adam, mut since, mut factor) = (Adam::new(point.len()), 0, 1.0);
        let mut best = (f64::INFINITY, point.clone());
        for step in 1..=steps {
            let here: Vec<f64> = point.iter().map(|u| f64::from(*u)).collect();
            match tried.slope(&here, truncation.unwrap_or(usize::MAX), price) {
                Some(found) => {
                    if found.cost < best.0 {
                        best = (found.cost, point.clone());
                    }
                    let slope: Vec<f32> = found.slope.iter().map(|g| *g as f32).collect();
                    since += 1;
                    adam.step(since, &mut point, &slope, factor * rate_at(step, steps, 0, rate, LAST));
                }
                None if best.0.is_finite() => {
                    point.clone_from(&best.1);
                    (adam, since, factor) = (Adam::new(point.len()), 0, 0.5 * factor);
                }
                // Not even the start has a value: there is no way down from here.
                None => return each(None),
            }
            point.iter_mut().for_each(|u| *u = u.clamp(0.0, 1.0));
            each(Some(factor * rate_at(step, steps, 0, rate, LAST)))?;
        }
        Ok(())
    }
}
