//! Bayesian optimisation: the next point is where the most improvement is to be expected.
use super::gaussian_process::{GaussianProcess, expected_improvement};
use super::tried::HOPELESS;
use super::{Each, Search, Start, Tried};
use crate::state::stream;
use anyhow::ensure;
use rand::Rng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Config of [`Bayesian`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct BayesianSpec {
    /// Points of a Latin hypercube before the first that is chosen, for each constant.
    #[schemars(range(min = 1))]
    pub first: usize,
    /// Evaluations between two looks for the lengths of the process.
    #[schemars(range(min = 1))]
    pub refit: usize,
    /// Points among which the most promising is looked for, half of them near the best so far.
    #[schemars(range(min = 2))]
    pub candidates: usize,
}

impl Default for BayesianSpec {
    fn default() -> Self {
        Self { first: 2, refit: 10, candidates: 512 }
    }
}

impl BayesianSpec {
    pub(crate) fn build(self) -> anyhow::Result<Bayesian> {
        for (key, value) in [("first", self.first), ("refit", self.refit), ("candidates", self.candidates)] {
            ensure!(value > 0, "`{key}` of the search is 0; give at least 1");
        }
        Ok(Bayesian(self))
    }
}

/// A Gaussian process through the logarithms of costs and expected improvement (Jones, Schonlau & Welch 1998).
pub struct Bayesian(BayesianSpec);

impl Search for Bayesian {
    fn search(&self, start: &Start, tried: &Tried<'_>, each: &mut Each<'_>) -> anyhow::Result<()> {
        let count = start.point.len();
        let mut rng = stream(start.seed, &[u64::from_le_bytes(*b"bayesian")]);
        let mut points = vec![start.point.clone()];
        points.extend(latin_hypercube(self.0.first * count, count, &mut rng));
        points.truncate(start.evaluations);
        let mut costs: Vec<f64> = points.par_iter().map(|point| tried.cost(point)).collect();
        each(None)?;
        let mut lengths = vec![0.4; count];
        while points.len() < start.evaluations {
            let values = logarithms(&costs);
            let process =
                match (points.len() - 1).is_multiple_of(self.0.refit) || points.len() <= 1 + self.0.first * count {
                    true => GaussianProcess::new(points.clone(), &values, lengths),
                    false => GaussianProcess::with(points.clone(), &values, lengths),
                };
            lengths = process.lengths().to_vec();
            let next = self.next(&process, &points, &values, &mut rng);
            costs.push(tried.cost(&next));
            points.push(next);
            each(None)?;
        }
        Ok(())
    }
}

impl Bayesian {
    /// Where the most improvement is expected: the best of many candidates, moved a little at a time.
    fn next(&self, process: &GaussianProcess, points: &[Vec<f64>], values: &[f64], rng: &mut ChaCha8Rng) -> Vec<f64> {
        let least = values.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1)).expect("a value of the start");
        let (best, lowest) = (&points[least.0], *least.1);
        let score = |point: &Vec<f64>| {
            let (mean, deviation) = process.predict(point);
            expected_improvement(mean, deviation, lowest)
        };
        let mut candidates: Vec<Vec<f64>> =
            (0..self.0.candidates / 2).map(|k| near(best, SIZES[k % SIZES.len()], rng)).collect();
        candidates.extend(latin_hypercube(self.0.candidates - candidates.len(), best.len(), rng));
        let mut found = most(candidates, score);
        for size in SIZES {
            let mut all = vec![found.clone()];
            all.extend((0..self.0.candidates / 8).map(|_| near(&found, size, rng)));
            found = most(all, score);
        }
        found
    }
}

/// Standard deviations of candidates around a point.
const SIZES: [f64; 4] = [0.1, 0.03, 0.01, 0.003];

/// A point of the box, normally distributed around another.
fn near(point: &[f64], size: f64, rng: &mut ChaCha8Rng) -> Vec<f64> {
    let mut normal = || -> f64 { StandardNormal.sample(rng) };
    point.iter().map(|u| (u + size * normal()).clamp(0.0, 1.0)).collect()
}

/// The candidate with the highest score, the first of equals.
fn most(candidates: Vec<Vec<f64>>, score: impl Fn(&Vec<f64>) -> f64 + Sync) -> Vec<f64> {
    let scores: Vec<f64> = candidates.par_iter().map(&score).collect();
    let first = (0..scores.len()).rev().max_by(|a, b| scores[*a].total_cmp(&scores[*b])).expect("a candidate");
    candidates.into_iter().nth(first).expect("a place among them")
}

/// Points of which each coordinate falls once into each of equal shares (McKay, Beckman & Conover 1979).
fn latin_hypercube(points: usize, dimensions: usize, rng: &mut ChaCha8Rng) -> Vec<Vec<f64>> {
    let mut all = vec![vec![0.0; dimensions]; points];
    for k in 0..dimensions {
        let mut shares: Vec<usize> = (0..points).collect();
        shares.shuffle(rng);
        for (point, share) in all.iter_mut().zip(shares) {
            point[k] = (share as f64 + rng.random::<f64>()) / points as f64;
        }
    }
    all
}

/// Logarithms of costs; what diverged counts as the worst that did not.
fn logarithms(costs: &[f64]) -> Vec<f64> {
    let logarithm = |cost: &f64| cost.max(f64::MIN_POSITIVE).ln();
    let worst = costs.iter().filter(|c| **c < HOPELESS).map(logarithm).fold(f64::NEG_INFINITY, f64::max);
    let worst = if worst.is_finite() { worst } else { 0.0 };
    costs.iter().map(|cost| logarithm(cost).min(worst)).collect()
}
