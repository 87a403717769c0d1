//! Projected gradient descent with Adam's scaling, from several starts at once.
use super::best::Best;
use super::starts::others;
use super::{Objective, Plan, Planner, starts, within};
use anyhow::ensure;
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Config of [`Descent`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DescentSpec {
    /// Plans costed without gradient first, the middle of the box among them.
    #[schemars(range(min = 1))]
    pub candidates: usize,
    /// Plans that descend: the middle of the box, and the cheapest other candidates.
    #[schemars(range(min = 1))]
    pub starts: usize,
    /// Most steps of each start.
    #[schemars(range(min = 1))]
    pub steps: usize,
    /// Length of the first step along each coordinate \[fraction of the box\].
    #[schemars(range(min = 0.0, max = 1.0))]
    pub rate: f64,
    /// Length of the last step; the lengths between fall geometrically \[fraction of the box\].
    #[schemars(range(min = 0.0, max = 1.0))]
    pub last_rate: f64,
    /// Decay of the running mean of gradients (Adam's β₁).
    #[schemars(range(min = 0.0, max = 1.0))]
    pub momentum: f64,
    /// Decay of the running mean of squared gradients (Adam's β₂).
    #[schemars(range(min = 0.0, max = 1.0))]
    pub memory: f64,
}

impl DescentSpec {
    pub(crate) fn build(self) -> anyhow::Result<Descent> {
        let Self { candidates, starts, steps, rate, last_rate, .. } = self;
        starts::check(candidates, starts)?;
        ensure!(steps >= 1, "planner.steps must be at least 1");
        ensure!(rate > 0.0 && rate <= 1.0, "planner.rate must lie in (0, 1], got {rate}");
        ensure!(
            last_rate > 0.0 && last_rate <= rate,
            "planner.last_rate must lie in (0, planner.rate = {rate}], got {last_rate}"
        );
        for (key, value) in [("momentum", self.momentum), ("memory", self.memory)] {
            ensure!((0.0..1.0).contains(&value), "planner.{key} must lie in [0, 1), got {value}");
        }
        Ok(Descent { spec: self })
    }
}

/// `u ← clamp(u − rate · m̂ / √v̂)` over fractions u of the box, m̂ and v̂ Adam's means of `∂J/∂u` (Kingma & Ba 2015, alg. 1).
///
/// All starts advance together, so that a budget which ends early is shared between them; the best plan seen wins.
#[derive(Clone, Debug)]
pub struct Descent {
    spec: DescentSpec,
}

/// One start on its way down.
struct Walker {
    unit: Vec<f64>,
    mean: Vec<f64>,
    square: Vec<f64>,
}

impl Planner for Descent {
    fn plan(&self, objective: &dyn Objective, rng: &mut ChaCha8Rng) -> Option<Plan> {
        let middle = vec![0.5; objective.space().dimension()];
        // Asked before any rollout is spent, and kept for the middle's own first step.
        let known = objective.gradient(&within(objective.space(), &middle))?;
        let mut best = Best::default();
        let mut starts = vec![middle];
        starts.extend(others(objective, self.spec.candidates - 1, self.spec.starts - 1, &mut best, rng));
        self.descend(objective, starts, Some(known), &mut best);
        best.into_plan()
    }

    fn wants_gradients(&self) -> bool {
        true
    }
}

impl Descent {
    /// Descends from all `starts` \[fractions of the box\] at once; `known` is the first one's cost and gradient.
    pub(super) fn descend(
        &self,
        objective: &dyn Objective,
        starts: Vec<Vec<f64>>,
        known: Option<(f64, Vec<f64>)>,
        best: &mut Best,
    ) {
        let (space, spec) = (objective.space(), &self.spec);
        let mut known: Vec<_> = known.into_iter().map(Some).collect();
        let mut walkers: Vec<_> = starts.into_iter().map(Walker::at).collect();
        for step in 0..spec.steps {
            let plans = places(&walkers, objective);
            let mut answers = std::mem::take(&mut known);
            answers.extend(objective.gradients(&plans[answers.len()..]));
            let progress = step as f64 / (spec.steps - 1).max(1) as f64;
            let rate = spec.rate * (spec.last_rate / spec.rate).powf(progress);
            let mut answers = answers.into_iter().zip(&plans);
            walkers.retain_mut(|walker| {
                let Some((Some((cost, gradient)), plan)) = answers.next() else { return false };
                best.see(plan, cost);
                let slope = space.by_unit(&gradient);
                cost.is_finite() && slope.iter().all(|s| s.is_finite()) && walker.step(&slope, step, rate, spec)
            });
        }
        best.costs(objective, &places(&walkers, objective));
    }
}

fn places(walkers: &[Walker], objective: &dyn Objective) -> Vec<Vec<f64>> {
    walkers.iter().map(|w| within(objective.space(), &w.unit)).collect()
}

impl Walker {
    fn at(unit: Vec<f64>) -> Self {
        Self { mean: vec![0.0; unit.len()], square: vec![0.0; unit.len()], unit }
    }

    /// Moves along `slope` = ∂J/∂u; `false` where every coordinate is flat or pushed against its bound, as nothing lies further.
    fn step(&mut self, slope: &[f64], step: usize, rate: f64, spec: &DescentSpec) -> bool {
        let held = |(u, s): (&f64, &f64)| *s == 0.0 || *u <= 0.0 && *s > 0.0 || *u >= 1.0 && *s < 0.0;
        if self.unit.iter().zip(slope).all(held) {
            return false;
        }
        let unbiased = |decay: f64| 1.0 - decay.powi(step as i32 + 1);
        for (axis, s) in slope.iter().enumerate() {
            self.mean[axis] += (1.0 - spec.momentum) * (s - self.mean[axis]);
            self.square[axis] += (1.0 - spec.memory) * (s * s - self.square[axis]);
            let scale = (self.square[axis] / unbiased(spec.memory)).sqrt();
            if scale > 0.0 {
                let move_by = rate * self.mean[axis] / unbiased(spec.momentum) / scale;
                self.unit[axis] = (self.unit[axis] - move_by).clamp(0.0, 1.0);
            }
        }
        true
    }
}
