//! What a finished identification reports.
use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

/// What a finished identification reports, also in `identify.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Identification {
    /// By path.
    pub constants: IndexMap<String, Constant>,
    /// Error on the windows that were fitted to.
    pub train: Errors,
    /// Error on windows of episodes that were not, taken in the same way.
    pub held_out: Option<Errors>,
    /// Sets of constants that were tried, a gradient counting as many as its price.
    pub evaluations: usize,
    /// Wall time of the search in its last run \[s\].
    #[serde(default)]
    pub seconds: f64,
}

/// A constant before and after, and its bounds, in its own unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Constant {
    /// In the model's config.
    pub before: f64,
    /// The best found.
    pub after: f64,
    /// Lower bound.
    pub low: f64,
    /// Upper bound.
    pub high: f64,
    /// Error on the fitted windows with 0.9 and 1.1 of the best found, all else as found \[m\]; `None` when not finite.
    #[serde(default)]
    pub beside: [Option<f64>; 2],
}

/// Root mean square position error over windows, their steps and particles \[m\].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// With the constants of the model's config; `None` when not finite.
    pub before: Option<f64>,
    /// With the constants found; `None` when not finite.
    pub after: Option<f64>,
    /// If nothing ever moved.
    pub still: f64,
}

/// What the constants are multiplied with where their sensitivity is asked for.
pub(super) const BESIDE: [f64; 2] = [0.9, 1.1];
