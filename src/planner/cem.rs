//! The cross-entropy method with a diagonal Gaussian.
use super::Sampler;
use anyhow::ensure;
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Config of [`Cem`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CemSpec {
    /// Plans in the first round.
    #[schemars(range(min = 2))]
    pub samples: usize,
    /// Factor on the number of plans from one round to the next.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub decay: f64,
    /// Plans in a round once decay has done its work.
    #[schemars(range(min = 2))]
    pub fewest: usize,
    /// Cheapest plans of a round that the next round's Gaussian is fitted to.
    #[schemars(range(min = 2))]
    pub elites: usize,
    /// Most rounds.
    #[schemars(range(min = 1))]
    pub rounds: usize,
    /// Standard deviation of the first round \[fraction of the box\].
    #[schemars(range(min = 0.0))]
    pub spread: f64,
    /// Least standard deviation of any round \[fraction of the box\].
    #[schemars(range(min = 0.0))]
    pub least_spread: f64,
    /// Weight of the last round's mean and deviation in the next one's.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub smoothing: f64,
    /// Rounds without improvement after which the search stops.
    #[schemars(range(min = 1))]
    pub patience: usize,
    /// Least relative fall of the cost that counts as improvement.
    #[schemars(range(min = 0.0))]
    pub tolerance: f64,
}

impl CemSpec {
    pub(crate) fn build(self) -> anyhow::Result<Cem> {
        let Self { samples, fewest, elites, rounds, patience, .. } = self;
        ensure!(elites >= 2, "planner.elites must be at least 2, got {elites}: one plan has no deviation");
        ensure!(
            fewest >= elites,
            "planner.fewest = {fewest} leaves fewer plans in a round than planner.elites = {elites}"
        );
        ensure!(samples >= fewest, "planner.samples = {samples} is less than planner.fewest = {fewest}");
        ensure!(rounds >= 1, "planner.rounds must be at least 1");
        ensure!(patience >= 1, "planner.patience must be at least 1");
        for (key, value) in [("decay", self.decay), ("smoothing", self.smoothing)] {
            ensure!((0.0..=1.0).contains(&value), "planner.{key} must lie in [0, 1], got {value}");
        }
        for (key, value) in [("least_spread", self.least_spread), ("tolerance", self.tolerance)] {
            ensure!(value >= 0.0 && value.is_finite(), "planner.{key} must be at least 0, got {value}");
        }
        ensure!(self.spread > 0.0 && self.spread.is_finite(), "planner.spread must be positive, got {}", self.spread);
        Ok(Cem { spec: self })
    }
}

/// Draws from a Gaussian, fits it to the cheapest draws, and repeats (Rubinstein 1999; de Boer et al. 2005, §3).
///
/// Every round costs the Gaussian's mean too, so that the first one costs the middle of the box. The number of plans falls by
/// `decay` a round, as in RoboCook and iCEM (Pinneri et al. 2020).
#[derive(Clone, Debug)]
pub struct Cem {
    spec: CemSpec,
}

/// Mean and standard deviation of each coordinate \[fraction of the box\].
pub struct Gaussian {
    mean: Vec<f64>,
    deviation: Vec<f64>,
}

impl Cem {
    /// The first round's Gaussian around `mean` \[fractions of the box\].
    pub(super) fn around(&self, mean: Vec<f64>) -> Gaussian {
        Gaussian { deviation: vec![self.spec.spread; mean.len()], mean }
    }
}

impl Sampler for Cem {
    type Params = Gaussian;

    fn init(&self, dimension: usize) -> Gaussian {
        self.around(vec![0.5; dimension])
    }

    fn sample(&self, gaussian: &Gaussian, round: usize, rng: &mut ChaCha8Rng) -> Vec<Vec<f64>> {
        let decayed = self.spec.samples as f64 * self.spec.decay.powi(round.min(i32::MAX as usize) as i32);
        let count = (decayed.round() as usize).max(self.spec.fewest);
        let mut draw = || {
            let axes = gaussian.mean.iter().zip(&gaussian.deviation);
            axes.map(|(m, s)| m + s * rng.sample::<f64, _>(StandardNormal)).collect()
        };
        std::iter::once(gaussian.mean.clone()).chain((1..count).map(|_| draw())).collect()
    }

    fn update(&self, old: Gaussian, samples: &[Vec<f64>], costs: &[f64]) -> Gaussian {
        let mut order: Vec<usize> = (0..samples.len()).filter(|&i| costs[i].is_finite()).collect();
        order.sort_by(|&a, &b| costs[a].total_cmp(&costs[b]));
        order.truncate(self.spec.elites);
        // A single survivor says where to look but not how widely: its deviation would be zero.
        if order.len() < 2 {
            return old;
        }
        let (n, keep) = (order.len() as f64, self.spec.smoothing);
        let fit = |axis: usize| {
            let mean = order.iter().map(|&i| samples[i][axis]).sum::<f64>() / n;
            let variance = order.iter().map(|&i| (samples[i][axis] - mean).powi(2)).sum::<f64>() / n;
            let deviation = keep * old.deviation[axis] + (1.0 - keep) * variance.sqrt();
            (keep * old.mean[axis] + (1.0 - keep) * mean, deviation.max(self.spec.least_spread))
        };
        let (mean, deviation) = (0..old.mean.len()).map(fit).unzip();
        Gaussian { mean, deviation }
    }

    fn done(&self, least: &[f64]) -> bool {
        let Self { spec: CemSpec { rounds, patience, tolerance, .. } } = self;
        let stalled = least.len() > *patience && {
            let (now, before) = (least[least.len() - 1], least[least.len() - 1 - patience]);
            // Written so that ∞ against ∞, where nothing finite was found yet, goes on.
            before - now <= tolerance * before.abs()
        };
        least.len() >= *rounds || stalled
    }
}
