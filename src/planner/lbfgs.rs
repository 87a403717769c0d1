//! Projected L-BFGS from several starts.
use super::best::Best;
use super::starts::others;
use super::{Objective, Plan, Planner, starts, within};
use crate::state::ActionSpace;
use anyhow::ensure;
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// Config of [`Lbfgs`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LbfgsSpec {
    /// Plans costed without gradient first, the middle of the box among them.
    #[schemars(range(min = 1))]
    pub candidates: usize,
    /// Plans that descend, all at once: the middle of the box, and the cheapest other candidates.
    #[schemars(range(min = 1))]
    pub starts: usize,
    /// Most gradients of each start.
    #[schemars(range(min = 1))]
    pub steps: usize,
    /// Pairs of steps and gradient changes that the inverse Hessian is made of.
    #[schemars(range(min = 1))]
    pub memory: usize,
    /// Greatest length of the first step along each coordinate \[fraction of the box\].
    #[schemars(range(min = 0.0, max = 1.0))]
    pub rate: f64,
}

/// The two-loop recursion (Nocedal & Wright 2006, alg. 7.4) over the coordinates that are free to move, with Armijo backtracking
/// along the path projected onto the box (Bertsekas 1982).
#[derive(Clone, Debug)]
pub struct Lbfgs {
    spec: LbfgsSpec,
}

/// Fall of the cost per predicted fall that a step needs (Armijo's constant).
const FALL: f64 = 1e-4;

impl LbfgsSpec {
    pub(crate) fn build(self) -> anyhow::Result<Lbfgs> {
        let Self { candidates, starts, steps, memory, rate } = self;
        starts::check(candidates, starts)?;
        ensure!(steps >= 1, "planner.steps must be at least 1");
        ensure!(memory >= 1, "planner.memory must be at least 1");
        ensure!(rate > 0.0 && rate <= 1.0, "planner.rate must lie in (0, 1], got {rate}");
        Ok(Lbfgs { spec: self })
    }
}

/// One start on its way down.
struct Walker {
    /// Fractions of the box.
    at: Vec<f64>,
    cost: f64,
    /// `∂J/∂u`.
    gradient: Vec<f64>,
    /// Pairs of steps and gradient changes.
    memory: VecDeque<(Vec<f64>, Vec<f64>)>,
    /// Share of the next step that is taken.
    length: f64,
}

impl Planner for Lbfgs {
    fn plan(&self, objective: &dyn Objective, rng: &mut ChaCha8Rng) -> Option<Plan> {
        let (space, mut best) = (objective.space(), Best::default());
        let middle = vec![0.5; space.dimension()];
        // Asked before any rollout is spent: without a gradient there is no plan.
        let known = objective.gradient(&within(space, &middle))?;
        let mut starts = vec![middle];
        starts.extend(others(objective, self.spec.candidates - 1, self.spec.starts - 1, &mut best, rng));
        let plans: Vec<_> = starts.iter().map(|unit| within(space, unit)).collect();
        let answers = [Some(known)].into_iter().chain(objective.gradients(&plans[1..]));
        let begun = starts.into_iter().zip(plans.iter().zip(answers));
        let begun =
            begun.filter_map(|(unit, (plan, answer))| Some(Walker::at(unit, slope(space, plan, answer, &mut best)?)));
        let mut walkers: Vec<Walker> = begun.collect();
        for _ in 1..self.spec.steps {
            let mut next = Vec::with_capacity(walkers.len());
            walkers.retain_mut(|walker| walker.next(self.spec.rate).map(|unit| next.push(unit)).is_some());
            if walkers.is_empty() || objective.exhausted() {
                break;
            }
            let plans: Vec<_> = next.iter().map(|unit| within(space, unit)).collect();
            let answers = objective.gradients(&plans);
            for ((walker, unit), (plan, answer)) in walkers.iter_mut().zip(next).zip(plans.iter().zip(answers)) {
                walker.judge(unit, slope(space, plan, answer, &mut best), self.spec.memory);
            }
        }
        best.into_plan()
    }

    fn wants_gradients(&self) -> bool {
        true
    }
}

/// Cost and `∂J/∂u` of what a gradient was answered with, `None` where there is none or either is not finite.
fn slope(
    space: &ActionSpace,
    plan: &[f64],
    answer: Option<(f64, Vec<f64>)>,
    best: &mut Best,
) -> Option<(f64, Vec<f64>)> {
    let (cost, gradient) = answer?;
    best.see(plan, cost);
    let slope = space.by_unit(&gradient);
    (cost.is_finite() && slope.iter().all(|s| s.is_finite())).then_some((cost, slope))
}

impl Walker {
    fn at(at: Vec<f64>, (cost, gradient): (f64, Vec<f64>)) -> Self {
        Self { at, cost, gradient, memory: VecDeque::new(), length: 1.0 }
    }

    /// Where it looks next; nowhere once every coordinate is flat or pushed against its bound, or a step would be none.
    fn next(&mut self, rate: f64) -> Option<Vec<f64>> {
        let held = |(u, g): (&f64, &f64)| *u <= 0.0 && *g > 0.0 || *u >= 1.0 && *g < 0.0;
        let free: Vec<bool> = self.at.iter().zip(&self.gradient).map(|pair| !held(pair)).collect();
        let masked =
            |v: &[f64]| -> Vec<f64> { v.iter().zip(&free).map(|(x, free)| if *free { *x } else { 0.0 }).collect() };
        let steepest = masked(&self.gradient);
        let largest = steepest.iter().fold(0.0, |m: f64, g| m.max(g.abs()));
        if largest == 0.0 {
            return None;
        }
        let mut direction = self.direction(&steepest, &masked);
        if self.memory.is_empty() || dot(&direction, &steepest) >= 0.0 {
            self.memory.clear();
            direction = steepest.iter().map(|g| -g * rate / largest).collect();
        }
        let ahead = |(u, d): (&f64, &f64)| (u + self.length * d).clamp(0.0, 1.0);
        let next: Vec<f64> = self.at.iter().zip(&direction).map(ahead).collect();
        next.iter().zip(&self.at).any(|(b, a)| (b - a).abs() >= 1e-12).then_some(next)
    }

    /// Goes to `next` where that is low enough, else looks nearer by.
    fn judge(&mut self, next: Vec<f64>, found: Option<(f64, Vec<f64>)>, most: usize) {
        let step: Vec<f64> = next.iter().zip(&self.at).map(|(b, a)| b - a).collect();
        let Some((cost, gradient)) = found.filter(|(cost, _)| *cost <= self.cost + FALL * dot(&step, &self.gradient))
        else {
            self.length /= 4.0;
            return;
        };
        let turn: Vec<f64> = gradient.iter().zip(&self.gradient).map(|(b, a)| b - a).collect();
        if dot(&turn, &step) > 1e-10 * dot(&turn, &turn).sqrt() * dot(&step, &step).sqrt() {
            self.memory.push_back((step, turn));
            if self.memory.len() > most {
                self.memory.pop_front();
            }
        }
        (self.at, self.cost, self.gradient, self.length) = (next, cost, gradient, 1.0);
    }

    /// `−H g` with H the inverse Hessian that `memory` describes on the free coordinates.
    fn direction(&self, gradient: &[f64], masked: &dyn Fn(&[f64]) -> Vec<f64>) -> Vec<f64> {
        let pairs: Vec<_> = self.memory.iter().map(|(s, y)| (masked(s), masked(y))).collect();
        let pairs: Vec<_> = pairs.into_iter().filter(|(s, y)| dot(s, y) > 0.0).collect();
        let mut q = gradient.to_vec();
        let mut alphas = Vec::with_capacity(pairs.len());
        for (s, y) in pairs.iter().rev() {
            let alpha = dot(s, &q) / dot(s, y);
            q.iter_mut().zip(y).for_each(|(q, y)| *q -= alpha * y);
            alphas.push(alpha);
        }
        if let Some((s, y)) = pairs.last() {
            let scale = dot(s, y) / dot(y, y);
            q.iter_mut().for_each(|q| *q *= scale);
        }
        for ((s, y), alpha) in pairs.iter().zip(alphas.into_iter().rev()) {
            let beta = dot(y, &q) / dot(s, y);
            q.iter_mut().zip(s).for_each(|(q, s)| *q += (alpha - beta) * s);
        }
        q.into_iter().map(|q| -q).collect()
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}
