//! CMA-ES on the unit box.
use super::{Each, Search, Start, Tried};
use cmaes::{CMAESOptions, DVector};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Config of [`Cma`], whose first standard deviation and seed are the identification's.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CmaSpec {}

impl CmaSpec {
    pub(crate) fn build(self) -> anyhow::Result<Cma> {
        Ok(Cma)
    }
}

/// Covariance matrix adaptation (Hansen & Ostermeier 2001); points outside the box are reflected into it.
///
/// Generations are evaluated in parallel; the result does not depend on the number of threads.
pub struct Cma;

impl Search for Cma {
    fn search(&self, start: &Start, tried: &Tried<'_>, each: &mut Each<'_>) -> anyhow::Result<()> {
        let ask = |point: &[f64]| tried.cost(&point.iter().map(|x| reflect(*x)).collect::<Vec<f64>>());
        ask(&start.point);
        let mut strategy = CMAESOptions::new(start.point.clone(), start.sigma)
            .seed(start.seed)
            .build(|x: &DVector<f64>| ask(x.as_slice()))
            .map_err(|e| anyhow::anyhow!("the search over constants cannot start: {e:?}"))?;
        let population = strategy.parameters().lambda();
        // The last evaluation is kept for the distribution's mean, often better than any of its samples.
        while strategy.function_evals() + population + 2 <= start.evaluations {
            let ended = strategy.next_parallel().is_some();
            each(Some(strategy.sigma()))?;
            if ended {
                break;
            }
        }
        ask(strategy.mean().as_slice());
        Ok(())
    }
}

/// Folds the real line into [0, 1] like a mirror at either end.
fn reflect(x: f64) -> f64 {
    let x = x.rem_euclid(2.0);
    if x > 1.0 { 2.0 - x } else { x }
}
