//! CMA-ES on the unit box, remembering every cost so that a stopped search goes on where it was.
use super::checkpoint::{load, save};
use anyhow::Context;
use cmaes::{CMAESOptions, DVector};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Mutex;

/// A cost that stands for "not finite": larger than any real one, and CMA-ES can still rank it.
const HOPELESS: f64 = 1e12;

/// Costs by the bits of the point in [0, 1]ᵈ.
type Known = BTreeMap<Vec<u64>, f64>;

/// What a search is told.
pub(super) struct Search<'a> {
    /// Where to start, in [0, 1]ᵈ.
    pub(super) start: Vec<f64>,
    /// First standard deviation.
    pub(super) sigma: f64,
    /// Seed.
    pub(super) seed: u64,
    /// How many points may be tried, the start included.
    pub(super) evaluations: usize,
    /// Where costs are remembered.
    pub(super) memory: &'a Path,
    /// What the costs are costs of.
    pub(super) identity: &'a str,
}

/// The best point of a search.
pub(super) struct Found {
    /// In [0, 1]ᵈ.
    pub(super) point: Vec<f64>,
    /// Its cost.
    pub(super) cost: f64,
    /// Points tried.
    pub(super) evaluations: usize,
}

impl Search<'_> {
    /// Minimises `cost` (Hansen & Ostermeier 2001); points outside the box are reflected into it.
    ///
    /// `each` hears after every generation its number, the best so far and the step size; an error from it ends the
    /// search, which goes on from there when called again. Generations are evaluated in parallel; the result does not
    /// depend on the number of threads.
    pub(super) fn minimise(
        &self,
        cost: impl Fn(&[f64]) -> f64 + Sync,
        mut each: impl FnMut(u64, &Found, f64) -> anyhow::Result<()>,
    ) -> anyhow::Result<Found> {
        let known: Mutex<Known> = Mutex::new(load(self.memory, self.identity)?.unwrap_or_default());
        let tried: Mutex<Known> = Mutex::default();
        let locked = |m: &Mutex<Known>| m.lock().expect("no thread panics while it holds the costs").clone();
        let ask = |point: &[f64]| {
            let point: Vec<f64> = point.iter().map(|x| reflect(*x)).collect();
            let key: Vec<u64> = point.iter().map(|x| x.to_bits()).collect();
            let remembered = locked(&known).get(&key).copied();
            let value = remembered.unwrap_or_else(|| {
                let value = cost(&point);
                if value.is_finite() { value.min(HOPELESS) } else { HOPELESS }
            });
            tried.lock().expect("no thread panics while it holds the costs").insert(key, value);
            value
        };
        ask(&self.start);
        let mut strategy = CMAESOptions::new(self.start.clone(), self.sigma)
            .seed(self.seed)
            .build(|x: &DVector<f64>| ask(x.as_slice()))
            .map_err(|e| anyhow::anyhow!("the search over constants cannot start: {e:?}"))?;
        let population = strategy.parameters().lambda();
        let mut generation = 0;
        // The last evaluation is kept for the distribution's mean, often better than any of its samples.
        while strategy.function_evals() + population + 2 <= self.evaluations {
            let ended = strategy.next_parallel().is_some();
            generation += 1;
            let so_far = locked(&tried);
            let mut all = locked(&known);
            all.extend(so_far.clone());
            save(self.memory, self.identity, &all)?;
            each(generation, &best(&so_far)?, strategy.sigma())?;
            if ended {
                break;
            }
        }
        ask(strategy.mean().as_slice());
        best(&locked(&tried))
    }
}

fn best(tried: &Known) -> anyhow::Result<Found> {
    let (key, cost) = tried.iter().min_by(|a, b| a.1.total_cmp(b.1)).context("no constants were tried")?;
    let point = key.iter().map(|bits| f64::from_bits(*bits)).collect();
    Ok(Found { point, cost: *cost, evaluations: tried.len() })
}

/// Folds the real line into [0, 1] like a mirror at either end.
fn reflect(x: f64) -> f64 {
    let x = x.rem_euclid(2.0);
    if x > 1.0 { 2.0 - x } else { x }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_the_bottom_of_a_curved_valley_and_never_leaves_the_box() {
        let folder = tempfile::tempdir().unwrap();
        let memory = folder.path().join("costs.bin");
        let start = vec![0.1, 0.9];
        let search = Search { start, sigma: 0.3, seed: 4, evaluations: 600, memory: &memory, identity: "valley" };
        let cost = |x: &[f64]| {
            assert!(x.iter().all(|x| (0.0..=1.0).contains(x)));
            100.0 * (x[1] - x[0] * x[0]).powi(2) + (0.6 - x[0]).powi(2)
        };
        let found = search.minimise(cost, |_, _, _| Ok(())).unwrap();
        assert!((found.point[0] - 0.6).abs() < 1e-3 && (found.point[1] - 0.36).abs() < 1e-3, "{:?}", found.point);
        assert!(found.evaluations <= 600);
    }

    #[test]
    fn a_stopped_search_goes_on_without_asking_twice() {
        let folder = tempfile::tempdir().unwrap();
        let memory = folder.path().join("costs.bin");
        let start = vec![0.5, 0.5, 0.5];
        let search = Search { start, sigma: 0.2, seed: 1, evaluations: 100, memory: &memory, identity: "bowl" };
        let asked = Mutex::new(0);
        let cost = |x: &[f64]| {
            *asked.lock().unwrap() += 1;
            x.iter().map(|x| (x - 0.3).powi(2)).sum()
        };
        let stop = search.minimise(cost, |g, _, _| if g == 5 { anyhow::bail!("enough") } else { Ok(()) });
        assert!(stop.is_err());
        let resumed = search.minimise(cost, |_, _, _| Ok(())).unwrap();
        assert_eq!(*asked.lock().unwrap(), resumed.evaluations);
        let fresh = Search { memory: &folder.path().join("other.bin"), ..search };
        assert_eq!(fresh.minimise(cost, |_, _, _| Ok(())).unwrap().point, resumed.point);
    }
}
