//! What a search has asked for: counted, and remembered so that a stopped search goes on.
use super::{Cone, Misfit, constants};
use crate::train::checkpoint::{load, save};
use anyhow::Context;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard};

/// A cost that stands for "not finite": larger than any real one, and searches can still rank it.
pub(super) const HOPELESS: f64 = 1e12;

/// J and its derivative by a point of the unit box.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Slope {
    /// J.
    pub cost: f64,
    /// `∂J/∂u`.
    pub slope: Vec<f64>,
}

/// `J = |r|²` with residuals r and relative changes `dₖ = δcₖ/cₖ` of d constants.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Squares {
    /// J.
    pub cost: f64,
    /// `½ ∂J/∂d = (∂r/∂d)ᵀ r`.
    pub slope: Vec<f64>,
    /// `(∂r/∂d)ᵀ (∂r/∂d)`, row by row.
    pub curvature: Vec<f64>,
}

/// The best point of a search.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// In \[0, 1\]ᵈ.
    pub point: Vec<f64>,
    /// Its cost.
    pub cost: f64,
    /// What was spent, a cost counting one.
    pub evaluations: usize,
}

/// The bits of a point.
type Key = Vec<u64>;
/// Costs by the bits of the point in \[0, 1\]ᵈ.
type Costs = BTreeMap<Key, f64>;

/// What asks for more than a cost gets, and its price.
#[derive(Clone, Default, Serialize, Deserialize)]
struct Derived {
    slopes: BTreeMap<Key, (Option<Slope>, usize)>,
    squares: BTreeMap<Key, (Option<Squares>, usize)>,
}

#[derive(Clone, Default)]
struct Known {
    costs: Costs,
    derived: Derived,
}

/// What was asked of a [`Misfit`], and is not asked twice.
pub struct Tried<'a> {
    misfit: &'a dyn Misfit,
    folder: PathBuf,
    identity: &'a str,
    /// Of earlier runs and this one.
    known: Mutex<Known>,
    /// Of this one.
    tried: Mutex<Known>,
}

fn locked(known: &Mutex<Known>) -> MutexGuard<'_, Known> {
    known.lock().expect("no thread panics while it holds the costs")
}

fn key(point: &[f64]) -> Key {
    point.iter().map(|x| x.to_bits()).collect()
}

impl<'a> Tried<'a> {
    /// With what an earlier run of the same `identity` has left in `folder`.
    ///
    /// # Errors
    /// When a file there is damaged, or belongs to another run.
    pub fn new(misfit: &'a dyn Misfit, folder: &Path, identity: &'a str) -> anyhow::Result<Self> {
        let (costs, derived) = (load(&folder.join(COSTS), identity)?, load(&folder.join(DERIVED), identity)?);
        let known = Known { costs: costs.unwrap_or_default(), derived: derived.unwrap_or_default() };
        Ok(Self { misfit, folder: folder.to_owned(), identity, known: Mutex::new(known), tried: Mutex::default() })
    }

    /// Lower and upper bound of every constant.
    pub fn bounds(&self) -> Vec<[f64; 2]> {
        self.misfit.bounds()
    }

    /// What the constants may be beside each other.
    pub fn cones(&self) -> &[Cone] {
        self.misfit.cones()
    }

    /// Whether the constants at `point` lie in all cones.
    pub fn holds(&self, point: &[f64]) -> bool {
        let constants = constants(point, &self.bounds());
        self.cones().iter().all(|cone| cone.holds(&constants))
    }

    /// J, for the price of one; a large number where it has no value or a cone forbids it.
    pub fn cost(&self, point: &[f64]) -> f64 {
        let key = key(point);
        let remembered = locked(&self.known).costs.get(&key).copied();
        let value = remembered.unwrap_or_else(|| {
            let value = if self.holds(point) { self.misfit.cost(point) } else { f64::INFINITY };
            if value.is_finite() { value.min(HOPELESS) } else { HOPELESS }
        });
        for of in [&self.known, &self.tried] {
            locked(of).costs.insert(key.clone(), value);
        }
        value
    }

    /// J and its derivative, for `price`; `None` where it has no value or a cone forbids it.
    pub fn slope(&self, point: &[f64], truncation: usize, price: usize) -> Option<Slope> {
        let key = key(point);
        let remembered = locked(&self.known).derived.slopes.get(&key).cloned();
        let (found, _) = remembered.unwrap_or_else(|| (self.asked(point, |m| m.slope(point, truncation)), price));
        for of in [&self.known, &self.tried] {
            locked(of).derived.slopes.insert(key.clone(), (found.clone(), price));
        }
        found
    }

    /// J as a sum of squares, for `price`; `None` likewise.
    pub fn squares(&self, point: &[f64], price: usize) -> Option<Squares> {
        let key = key(point);
        let remembered = locked(&self.known).derived.squares.get(&key).cloned();
        let (found, _) = remembered.unwrap_or_else(|| (self.asked(point, |m| m.squares(point)), price));
        for of in [&self.known, &self.tried] {
            locked(of).derived.squares.insert(key.clone(), (found.clone(), price));
        }
        found
    }

    fn asked<T>(&self, point: &[f64], of: impl FnOnce(&dyn Misfit) -> Option<T>) -> Option<T> {
        if self.holds(point) { of(self.misfit) } else { None }
    }

    /// What was asked so far, a cost counting one.
    pub fn spent(&self) -> usize {
        let Known { costs, derived } = &*locked(&self.tried);
        let slopes = derived.slopes.values().map(|(_, price)| *price);
        costs.len() + slopes.chain(derived.squares.values().map(|(_, price)| *price)).sum::<usize>()
    }

    /// The best point so far.
    ///
    /// # Errors
    /// When nothing was asked yet.
    pub fn best(&self) -> anyhow::Result<Found> {
        let evaluations = self.spent();
        let Known { costs, derived } = &*locked(&self.tried);
        let slopes = derived.slopes.iter().map(|(key, (found, _))| (key, found.as_ref().map_or(HOPELESS, |f| f.cost)));
        let squares =
            derived.squares.iter().map(|(key, (found, _))| (key, found.as_ref().map_or(HOPELESS, |f| f.cost)));
        let all = costs.iter().map(|(key, cost)| (key, *cost)).chain(slopes).chain(squares);
        let (key, cost) = all.min_by(|a, b| a.1.total_cmp(&b.1)).context("no constants were tried")?;
        Ok(Found { point: key.iter().map(|bits| f64::from_bits(*bits)).collect(), cost, evaluations })
    }

    /// Writes all that is known.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn save(&self) -> anyhow::Result<()> {
        let Known { costs, derived } = &*locked(&self.known);
        save(&self.folder.join(COSTS), self.identity, costs)?;
        if derived.slopes.is_empty() && derived.squares.is_empty() {
            return Ok(());
        }
        save(&self.folder.join(DERIVED), self.identity, derived)
    }
}

/// Costs.
const COSTS: &str = "costs.bin";
/// Derivatives, where a search asks for them.
const DERIVED: &str = "slopes.bin";
