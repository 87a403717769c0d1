//! CMA-ES first, gradients from where it ends.
use super::cma::Cma;
use super::gradient::{Descent, DescentSpec};
use super::{Each, Search, Start, Tried};
use anyhow::ensure;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Config of [`CmaThenGradient`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct CmaThenGradientSpec {
    /// Share of the evaluations that CMA-ES gets.
    #[schemars(range(min = 0.05, max = 0.95))]
    pub share: f64,
    /// The descent that follows.
    pub gradient: DescentSpec,
}

impl Default for CmaThenGradientSpec {
    fn default() -> Self {
        Self { share: 0.5, gradient: DescentSpec { rate: 0.02, ..DescentSpec::default() } }
    }
}

impl CmaThenGradientSpec {
    pub(crate) fn build(self) -> anyhow::Result<CmaThenGradient> {
        let Self { share, gradient } = self;
        ensure!(share > 0.0 && share < 1.0, "`share` of the search is {share}; give a number between 0 and 1");
        Ok(CmaThenGradient { share, gradient: gradient.build()? })
    }
}

/// A global search for a valley, then a descent into it (Jiang et al. 2025, PhysTwin).
pub struct CmaThenGradient {
    share: f64,
    gradient: Descent,
}

impl Search for CmaThenGradient {
    fn differentiates(&self) -> bool {
        true
    }

    fn search(&self, start: &Start, tried: &Tried<'_>, each: &mut Each<'_>) -> anyhow::Result<()> {
        let before = tried.spent();
        let first = (self.share * start.evaluations as f64) as usize;
        Cma.search(&Start { evaluations: first, ..start.clone() }, tried, each)?;
        let left = start.evaluations.saturating_sub(tried.spent() - before);
        self.gradient.search(&Start { point: tried.best()?.point, evaluations: left, ..start.clone() }, tried, each)
    }
}
