//! How badly constants fit windows of recorded motion.
use super::constants::replace;
use super::matched::Matched;
use super::search::{Cone, Misfit, Slope, Squares, constants};
use super::window::Window;
use crate::model::{Cost, WorldModel};
use indexmap::IndexMap;
use rayon::prelude::*;
use serde_json::Value;

/// Turns a model's config into a model.
pub(super) type Build<'a> = &'a (dyn Fn(&Value) -> anyhow::Result<Box<dyn WorldModel>> + Sync);

/// The [`Matched`] error over windows as a function of some constants of a model's config.
pub(super) struct Fitting<'a> {
    pub(super) model: &'a Value,
    pub(super) build: Build<'a>,
    pub(super) constants: &'a IndexMap<String, [f64; 2]>,
    pub(super) cones: &'a [Cone],
    pub(super) windows: &'a [Window<'a>],
    pub(super) scale: f64,
}

/// Relative change of a constant to either side that derivatives of whole rollouts by it are taken over.
const STEP: f64 = 1e-4;

impl Fitting<'_> {
    /// The constants at `point` of the unit box.
    pub(super) fn constants(&self, point: &[f64]) -> Vec<f64> {
        constants(point, &self.bounds())
    }

    /// The model's config with `constants`.
    pub(super) fn with(&self, constants: &[f64]) -> anyhow::Result<Value> {
        replace(self.model, self.constants.keys().map(String::as_str).zip(constants.iter().copied()))
    }

    /// The model with `constants`, or `None` where it refuses them, which is as bad as diverging.
    fn built(&self, constants: &[f64]) -> Option<Box<dyn WorldModel>> {
        self.with(constants).and_then(|spec| (self.build)(&spec)).ok()
    }

    /// The mean error with `constants`.
    pub(super) fn error(&self, constants: &[f64]) -> f64 {
        self.built(constants).map_or(f64::NAN, |model| mean_cost(&*model, self.windows, self.scale))
    }

    /// Where the model has these constants among those that it knows derivatives by.
    ///
    /// # Errors
    /// A sentence naming the first that it has none by.
    pub(super) fn places(&self, model: &dyn WorldModel) -> anyhow::Result<Vec<usize>> {
        let known = model.constants();
        let place = |path: &String| {
            let found = known.iter().position(|name| name == path);
            found.ok_or_else(|| {
                anyhow::anyhow!(
                    "the model has no derivative by `{path}`, which this search needs; leave the constant out, or choose \
                     search.kind = \"cma\", \"bayesian\" or \"random\""
                )
            })
        };
        self.constants.keys().map(place).collect()
    }

    /// J, and its derivative by the constants.
    fn gradient(&self, constants: &[f64], truncation: usize) -> Option<(f64, Vec<f64>)> {
        let model = self.built(constants)?;
        let places = self.places(&*model).ok()?;
        let one = |w: &Window<'_>| {
            let cost = Matched { targets: &w.targets, scale: self.scale };
            model.constant_gradient(&w.scene, &w.controls, &cost, truncation)
        };
        let all: Vec<_> = self.windows.par_iter().map(one).collect::<Option<_>>()?;
        let share = (all.len() as f64).recip();
        let cost = share * all.iter().map(|g| g.cost).sum::<f64>();
        let slope: Vec<f64> =
            places.iter().map(|place| share * all.iter().map(|g| g.constants[*place]).sum::<f64>()).collect();
        (cost.is_finite() && slope.iter().all(|g| g.is_finite())).then_some((cost, slope))
    }

    /// What the residuals of window `w` are, so that their squares over all windows add up to the mean error.
    fn residuals(&self, model: &dyn WorldModel, w: &Window<'_>) -> Vec<f64> {
        let count = w.scene.particles.len().max(1);
        let weight = (self.windows.len() * w.targets.len() * count) as f64;
        let unit = (weight.sqrt() * self.scale).recip();
        let rollout = model.rollout(&w.scene, &w.controls);
        let pairs = rollout[1..].iter().zip(w.targets.iter());
        let gaps = pairs.flat_map(|(x, y)| x.positions.iter().zip(&y.positions));
        gaps.flat_map(|(x, y)| (unit * (*x - *y)).to_array()).collect()
    }
}

impl Misfit for Fitting<'_> {
    fn bounds(&self) -> Vec<[f64; 2]> {
        self.constants.values().copied().collect()
    }

    fn cones(&self) -> &[Cone] {
        self.cones
    }

    fn cost(&self, point: &[f64]) -> f64 {
        self.error(&self.constants(point))
    }

    fn slope(&self, point: &[f64], truncation: usize) -> Option<Slope> {
        let constants = self.constants(point);
        let (cost, slope) = self.gradient(&constants, truncation)?;
        let rows = slope.iter().zip(&constants).zip(self.constants.values());
        // dc/du = c ln(high/low).
        Some(Slope { cost, slope: rows.map(|((g, c), [low, high])| g * c * (high / low).ln()).collect() })
    }

    /// The slope is exact; the design matrix has central differences of whole rollouts, a constant a column: the adjoint would need a
    /// sweep for every residual.
    fn squares(&self, point: &[f64]) -> Option<Squares> {
        let constants = self.constants(point);
        let (cost, slope) = self.gradient(&constants, usize::MAX)?;
        let count = constants.len();
        let beside = |k: usize, sign: f64| {
            let mut changed = constants.clone();
            changed[k] *= 1.0 + sign * STEP;
            self.built(&changed)
        };
        let models = |sign: f64| (0..count).map(|k| beside(k, sign)).collect::<Option<Vec<_>>>();
        let (above, below) = (models(1.0)?, models(-1.0)?);
        let product = |w: &Window<'_>| {
            let column = |k: usize| -> Vec<f64> {
                let ends = self.residuals(&*above[k], w).into_iter().zip(self.residuals(&*below[k], w));
                ends.map(|(a, b)| (a - b) / (2.0 * STEP)).collect()
            };
            let columns: Vec<Vec<f64>> = (0..count).map(column).collect();
            let dot = |i: usize, j: usize| columns[i].iter().zip(&columns[j]).map(|(a, b)| a * b).sum::<f64>();
            (0..count * count).map(|at| dot(at / count, at % count)).collect::<Vec<f64>>()
        };
        let products: Vec<Vec<f64>> = self.windows.par_iter().map(product).collect();
        let curvature: Vec<f64> = (0..count * count).map(|at| products.iter().map(|p| p[at]).sum()).collect();
        let slope = slope.iter().zip(&constants).map(|(g, c)| 0.5 * g * c).collect();
        curvature.iter().all(|h| h.is_finite()).then_some(Squares { cost, slope, curvature })
    }
}

/// Mean [`Matched`] error over windows, summed in their order.
pub(super) fn mean_cost(model: &dyn WorldModel, windows: &[Window<'_>], scale: f64) -> f64 {
    let costs: Vec<f64> = windows
        .par_iter()
        .map(|w| {
            let rollout = model.rollout(&w.scene, &w.controls);
            let finite = rollout.iter().all(|x| x.is_finite());
            if finite { Matched { targets: &w.targets, scale }.total(&rollout) } else { f64::INFINITY }
        })
        .collect();
    costs.iter().sum::<f64>() / costs.len() as f64
}
