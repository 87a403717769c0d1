//! Projected L-BFGS from several starts.
use super::best::Best;
use super::starts::others;
use super::{Objective, Plan, Planner, starts, within};
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
    /// Plans that descend, one after the other: the middle of the box, and the cheapest other candidates.
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

impl Planner for Lbfgs {
    fn plan(&self, objective: &dyn Objective, rng: &mut ChaCha8Rng) -> Option<Plan> {
        let (space, mut best) = (objective.space(), Best::default());
        let middle = vec![0.5; space.dimension()];
        let first = slope(objective, &middle, &mut best)?;
        let starts = others(objective, self.spec.candidates - 1, self.spec.starts - 1, &mut best, rng);
        self.descend(objective, middle, first, &mut best);
        for start in starts {
            if let Some(first) = slope(objective, &start, &mut best) {
                self.descend(objective, start, first, &mut best);
            }
        }
        best.into_plan()
    }

    fn wants_gradients(&self) -> bool {
        true
    }
}

/// Cost and `∂J/∂u` at fractions u of the box, `None` without a gradient or where either is not finite.
fn slope(objective: &dyn Objective, unit: &[f64], best: &mut Best) -> Option<(f64, Vec<f64>)> {
    let space = objective.space();
    let plan = within(space, unit);
    let (cost, gradient) = objective.gradient(&plan)?;
    best.see(&plan, cost);
    let slope = space.by_unit(&gradient);
    (cost.is_finite() && slope.iter().all(|s| s.is_finite())).then_some((cost, slope))
}

impl Lbfgs {
    fn descend(&self, objective: &dyn Objective, start: Vec<f64>, first: (f64, Vec<f64>), best: &mut Best) {
        let (mut at, (mut cost, mut gradient)) = (start, first);
        let mut memory: VecDeque<(Vec<f64>, Vec<f64>)> = VecDeque::new();
        let (mut length, mut spent) = (1.0, 1);
        while spent < self.spec.steps {
            let held = |(u, g): (&f64, &f64)| *u <= 0.0 && *g > 0.0 || *u >= 1.0 && *g < 0.0;
            let free: Vec<bool> = at.iter().zip(&gradient).map(|pair| !held(pair)).collect();
            let masked =
                |v: &[f64]| -> Vec<f64> { v.iter().zip(&free).map(|(x, free)| if *free { *x } else { 0.0 }).collect() };
            let steepest = masked(&gradient);
            let largest = steepest.iter().fold(0.0, |m: f64, g| m.max(g.abs()));
            if largest == 0.0 {
                return;
            }
            let mut direction = self.direction(&steepest, &memory, &masked);
            if memory.is_empty() || dot(&direction, &steepest) >= 0.0 {
                memory.clear();
                direction = steepest.iter().map(|g| -g * self.spec.rate / largest).collect();
            }
            let next: Vec<f64> = at.iter().zip(&direction).map(|(u, d)| (u + length * d).clamp(0.0, 1.0)).collect();
            let step: Vec<f64> = next.iter().zip(&at).map(|(b, a)| b - a).collect();
            if step.iter().all(|s| s.abs() < 1e-12) {
                return;
            }
            spent += 1;
            match slope(objective, &next, best) {
                Some((now, change)) if now <= cost + FALL * dot(&step, &gradient) => {
                    let turn: Vec<f64> = change.iter().zip(&gradient).map(|(b, a)| b - a).collect();
                    if dot(&turn, &step) > 1e-10 * dot(&turn, &turn).sqrt() * dot(&step, &step).sqrt() {
                        memory.push_back((step, turn));
                        if memory.len() > self.spec.memory {
                            memory.pop_front();
                        }
                    }
                    (at, cost, gradient, length) = (next, now, change, 1.0);
                }
                _ if objective.exhausted() => return,
                _ => length /= 4.0,
            }
        }
    }

    /// `−H g` with H the inverse Hessian that `memory` describes on the free coordinates.
    fn direction(
        &self,
        gradient: &[f64],
        memory: &VecDeque<(Vec<f64>, Vec<f64>)>,
        masked: &dyn Fn(&[f64]) -> Vec<f64>,
    ) -> Vec<f64> {
        let pairs: Vec<_> = memory.iter().map(|(s, y)| (masked(s), masked(y))).collect();
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
