//! Searches over a unit box: ways to find the constants that fit best.
//!
//! All minimise the same [`Misfit`] and are counted alike: [`Tried`] remembers what was asked, what it cost and where the best
//! lies, so that a stopped search goes on where it was.
mod bayesian;
mod cholesky;
mod cma;
mod cma_then_gradient;
mod cone;
mod gaussian_process;
mod gradient;
mod least_squares;
mod place;
mod quadratic;
mod random;
mod tried;

pub use bayesian::{Bayesian, BayesianSpec};
pub(super) use cholesky::Cholesky;
pub use cma::{Cma, CmaSpec};
pub use cma_then_gradient::{CmaThenGradient, CmaThenGradientSpec};
pub use cone::Cone;
pub use gaussian_process::{GaussianProcess, expected_improvement};
pub use gradient::{Descent, DescentSpec};
pub use least_squares::{LeastSquares, LeastSquaresSpec};
pub use place::{at, constants, place};
pub use quadratic::least_within;
pub use random::{Random, RandomSpec};
pub use tried::{Found, Slope, Squares, Tried};

/// What is minimised over the unit box, whose coordinates are logarithmic places of constants between their bounds.
pub trait Misfit: Sync {
    /// Lower and upper bound of every constant.
    fn bounds(&self) -> Vec<[f64; 2]>;
    /// What the constants may be beside each other: outside of any of these nothing is asked.
    fn cones(&self) -> &[Cone] {
        &[]
    }
    /// J; not finite where it has no value.
    fn cost(&self, point: &[f64]) -> f64;
    /// J and its derivative, taken back through at most `truncation` control steps; `None` where it has no value.
    fn slope(&self, point: &[f64], truncation: usize) -> Option<Slope>;
    /// J as a sum of squares, with what a Gauss–Newton step needs; `None` where it has no value.
    fn squares(&self, point: &[f64]) -> Option<Squares>;
}

/// Where a search starts and what it may spend.
#[derive(Clone, Debug, PartialEq)]
pub struct Start {
    /// In the unit box.
    pub point: Vec<f64>,
    /// How far around it a search that samples looks first.
    pub sigma: f64,
    /// Seed.
    pub seed: u64,
    /// Price of all that may be asked, a cost counting one.
    pub evaluations: usize,
}

/// Hears after every round of a search its step size, where it has one; an error from it ends the search.
pub type Each<'a> = dyn FnMut(Option<f64>) -> anyhow::Result<()> + 'a;

/// A way to search the unit box.
pub trait Search: Send + Sync {
    /// Whether it asks for derivatives.
    fn differentiates(&self) -> bool {
        false
    }
    /// Asks `tried` for what it needs until the evaluations of `start` are spent or nothing is left to gain; same start, same bits.
    ///
    /// # Errors
    /// What `each` fails with.
    fn search(&self, start: &Start, tried: &Tried<'_>, each: &mut Each<'_>) -> anyhow::Result<()>;
}

family! {
    /// Every search that a config can name.
    SearchSpec builds Box<dyn Search> {
        Cma(CmaSpec),
        Bayesian(BayesianSpec),
        Gradient(DescentSpec),
        CmaThenGradient(CmaThenGradientSpec),
        LeastSquares(LeastSquaresSpec),
        Random(RandomSpec),
    }
}

impl Default for SearchSpec {
    fn default() -> Self {
        Self::Cma(CmaSpec {})
    }
}

impl SearchSpec {
    /// Whether a config may leave the key out.
    pub(super) fn is_default(&self) -> bool {
        *self == Self::default()
    }
}
