//! Model-predictive path integral control: the mean moves to the samples' weighted mean.
use super::{Sampler, TemperatureSpec};
use anyhow::ensure;
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Config of [`Mppi`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MppiSpec {
    /// Plans in a round, the mean among them.
    #[schemars(range(min = 2))]
    pub samples: usize,
    /// Rounds.
    #[schemars(range(min = 1))]
    pub rounds: usize,
    /// Standard deviation σ of the first round \[fraction of the box\].
    #[schemars(range(min = 0.0))]
    pub spread: f64,
    /// Factor on σ from one round to the next.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub shrink: f64,
    /// How strongly cheap samples outweigh dear ones.
    pub temperature: TemperatureSpec,
}

/// `μ ← Σ wᵢ uᵢ`, `uᵢ ~ N(μ, σ² I)`, `wᵢ ∝ exp(−(Jᵢ − min J)/λ)` (Williams et al. 2017, eq. 34), over fractions of the box.
#[derive(Clone, Debug)]
pub struct Mppi {
    spec: MppiSpec,
}

impl MppiSpec {
    pub(super) fn check(&self) -> anyhow::Result<()> {
        let Self { samples, rounds, spread, shrink, .. } = self;
        ensure!(*samples >= 2, "planner.samples must be at least 2, got {samples}");
        ensure!(*rounds >= 1, "planner.rounds must be at least 1");
        ensure!(*spread > 0.0 && spread.is_finite(), "planner.spread must be positive, got {spread}");
        ensure!(*shrink > 0.0 && *shrink <= 1.0, "planner.shrink must lie in (0, 1], got {shrink}");
        self.temperature.check()
    }

    pub(crate) fn build(self) -> anyhow::Result<Mppi> {
        self.check()?;
        Ok(Mppi { spec: self })
    }

    /// Standard deviation of a round, counted from 0 \[fraction of the box\].
    pub(super) fn deviation(&self, round: usize) -> f64 {
        self.spread * self.shrink.powi(round.min(i32::MAX as usize) as i32)
    }

    /// The mean, and around it standard normal noise that `colour` has made the wanted covariance's.
    pub(super) fn samples(
        &self,
        mean: &[f64],
        colour: impl Fn(&[f64]) -> Vec<f64>,
        rng: &mut ChaCha8Rng,
    ) -> Vec<Vec<f64>> {
        let mut draw = |_| {
            let noise: Vec<f64> = mean.iter().map(|_| rng.sample(StandardNormal)).collect();
            mean.iter().zip(colour(&noise)).map(|(m, e)| m + e).collect()
        };
        std::iter::once(mean.to_vec()).chain((1..self.samples).map(&mut draw)).collect()
    }

    /// The weighted mean of `samples`, or `mean` where no cost is finite.
    pub(super) fn moved(&self, mean: Vec<f64>, samples: &[Vec<f64>], costs: &[f64]) -> Vec<f64> {
        let weights = self.temperature.weights(costs);
        if weights.iter().all(|w| *w == 0.0) {
            return mean;
        }
        (0..mean.len()).map(|axis| samples.iter().zip(&weights).map(|(u, w)| w * u[axis]).sum()).collect()
    }
}

impl Sampler for Mppi {
    /// The mean.
    type Params = Vec<f64>;

    fn init(&self, dimension: usize) -> Vec<f64> {
        vec![0.5; dimension]
    }

    fn sample(&self, mean: &Vec<f64>, round: usize, rng: &mut ChaCha8Rng) -> Vec<Vec<f64>> {
        let deviation = self.spec.deviation(round);
        self.spec.samples(mean, |noise| noise.iter().map(|e| deviation * e).collect(), rng)
    }

    fn update(&self, mean: Vec<f64>, samples: &[Vec<f64>], costs: &[f64]) -> Vec<f64> {
        self.spec.moved(mean, samples, costs)
    }

    fn done(&self, least: &[f64]) -> bool {
        least.len() >= self.spec.rounds
    }
}
