//! MPPI whose samples follow the cost's curvature.
use super::best::Best;
use super::{Covariance, FloorSpec, MppiSpec, Objective, Plan, Planner, within};
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Config of [`Covo`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CovoSpec {
    /// Samples, rounds, spread and temperature.
    pub mppi: MppiSpec,
    /// Reach of the differences that the Hessian is made of \[fraction of the box\].
    #[schemars(range(min = 0.0, max = 0.25))]
    pub reach: f64,
    /// What keeps directions without curvature in bounds.
    pub floor: FloorSpec,
}

/// CoVO-MPC (Yi et al. 2024): MPPI with `Σ ∝ R^{-1/2}` at the determinant of `σ² I`, R the cost's Hessian at the mean.
///
/// With gradients R is their central difference, 2 D gradients a round; without, that of the costs, 2 D² + 1 rollouts a round. Both
/// go through the objective, which counts them.
#[derive(Clone, Debug)]
pub struct Covo {
    spec: CovoSpec,
}

impl CovoSpec {
    pub(crate) fn build(self) -> anyhow::Result<Covo> {
        self.mppi.check()?;
        self.floor.check()?;
        let reach = self.reach;
        anyhow::ensure!(reach > 0.0 && reach <= 0.25, "planner.reach must lie in (0, 0.25], got {reach}");
        Ok(Covo { spec: self })
    }
}

impl Planner for Covo {
    fn plan(&self, objective: &dyn Objective, rng: &mut ChaCha8Rng) -> Option<Plan> {
        let spec = &self.spec.mppi;
        let (mut mean, mut best) = (vec![0.5; objective.space().dimension()], Best::default());
        for round in 0..spec.rounds {
            if objective.exhausted() {
                break;
            }
            let hessian = self.hessian(objective, &mean, &mut best);
            let covariance = Covariance::of(&hessian, spec.deviation(round), &self.spec.floor);
            let mut samples = spec.samples(&mean, |noise| covariance.colour(noise), rng);
            let costs = best.shoot(objective, &mut samples);
            mean = spec.moved(mean, &samples, &costs);
        }
        best.into_plan()
    }
}

impl Covo {
    /// `∂²J/∂u²` around `mean`, moved inside the box by the differences' reach; not a number where the budget ended.
    fn hessian(&self, objective: &dyn Objective, mean: &[f64], best: &mut Best) -> Vec<f64> {
        let (space, h) = (objective.space(), self.spec.reach);
        let centre: Vec<f64> = mean.iter().map(|u| u.clamp(h, 1.0 - h)).collect();
        let at = |nudges: &[(usize, f64)]| {
            let mut unit = centre.clone();
            nudges.iter().for_each(|(axis, by)| unit[*axis] += by);
            within(space, &unit)
        };
        let dimension = mean.len();
        let plans: Vec<_> = (0..dimension).flat_map(|i| [at(&[(i, h)]), at(&[(i, -h)])]).collect();
        let slopes = objective.gradients(&plans);
        if slopes.iter().any(Option::is_some) {
            slopes
                .iter()
                .zip(&plans)
                .filter_map(|(s, plan)| Some((plan, s.as_ref()?.0)))
                .for_each(|(p, c)| best.see(p, c));
            let slopes: Vec<_> = slopes.iter().map(|s| s.as_ref().map(|(_, g)| space.by_unit(g))).collect();
            let row = |i: usize, j: usize| match (&slopes[2 * i], &slopes[2 * i + 1]) {
                (Some(ahead), Some(behind)) => (ahead[j] - behind[j]) / (2.0 * h),
                _ => f64::NAN,
            };
            return (0..dimension * dimension).map(|k| row(k / dimension, k % dimension)).collect();
        }
        // J(c), J(c ± hᵢ), and J(c ± hᵢ ± hⱼ) for i < j: 1 + 2 D + 4 D (D − 1)/2 = 2 D² + 1.
        let pairs: Vec<(usize, usize)> = (0..dimension).flat_map(|i| (i + 1..dimension).map(move |j| (i, j))).collect();
        let corners = pairs
            .iter()
            .flat_map(|&(i, j)| [(h, h), (h, -h), (-h, h), (-h, -h)].map(|(by_i, by_j)| at(&[(i, by_i), (j, by_j)])));
        let all: Vec<_> = std::iter::once(at(&[])).chain(plans).chain(corners).collect();
        let costs = best.costs(objective, &all);
        let mut hessian = vec![0.0; dimension * dimension];
        for i in 0..dimension {
            hessian[i * dimension + i] = (costs[1 + 2 * i] - 2.0 * costs[0] + costs[2 + 2 * i]) / (h * h);
        }
        for (k, &(i, j)) in pairs.iter().enumerate() {
            let c = &costs[1 + 2 * dimension + 4 * k..][..4];
            let mixed = (c[0] - c[1] - c[2] + c[3]) / (4.0 * h * h);
            hessian[i * dimension + j] = mixed;
            hessian[j * dimension + i] = mixed;
        }
        hessian
    }
}

#[cfg(test)]
mod tests {
    use super::super::TemperatureSpec;
    use super::*;
    use crate::state::ActionSpace;

    /// `½ xᵀ A x + bᵀ x + c` on a box of unequal sides.
    struct Quadratic {
        space: ActionSpace,
        with_slope: bool,
    }

    const A: [[f64; 3]; 3] = [[3.0, -1.5, 0.4], [-1.5, -2.0, 0.7], [0.4, 0.7, 5.0]];
    const SIDES: [f64; 3] = [1.0, 0.5, 4.0];

    impl Quadratic {
        fn new(with_slope: bool) -> Self {
            let names = ["x", "y", "z"].map(String::from).to_vec();
            let low = vec![-0.3, 1.0, -2.0];
            let high = low.iter().zip(SIDES).map(|(low, side)| low + side).collect();
            Self { space: ActionSpace { names, low, high }, with_slope }
        }

        fn slope(x: &[f64]) -> Vec<f64> {
            A.iter()
                .zip([0.3, -0.2, 1.0])
                .map(|(row, b)| b + row.iter().zip(x).map(|(a, x)| a * x).sum::<f64>())
                .collect()
        }
    }

    impl Objective for Quadratic {
        fn space(&self) -> &ActionSpace {
            &self.space
        }
        fn costs(&self, plans: &[Vec<f64>]) -> Vec<f64> {
            // xᵀ (A x + b) = xᵀ A x + bᵀ x, and likewise at zero.
            let at_zero = Self::slope(&[0.0; 3]);
            let cost = |x: &Vec<f64>| {
                0.7 + x.iter().zip(Self::slope(x)).zip(&at_zero).map(|((x, s), b)| 0.5 * x * (s + b)).sum::<f64>()
            };
            plans.iter().map(cost).collect()
        }
        fn gradient(&self, plan: &[f64]) -> Option<(f64, Vec<f64>)> {
            self.with_slope.then(|| (self.costs(&[plan.to_vec()])[0], Self::slope(plan)))
        }
    }

    #[test]
    fn differences_of_a_quadratic_are_its_hessian_wherever_they_are_taken() {
        for with_slope in [false, true] {
            // In the middle, anywhere, and where the differences would leave the box.
            for (reach, mean) in [(0.05, [0.5; 3]), (0.1, [0.2, 0.9, 0.4]), (0.25, [0.0, 1.0, 0.97])] {
                let (objective, mut best) = (Quadratic::new(with_slope), Best::default());
                let temperature = TemperatureSpec::Fixed { value: 1.0 };
                let mppi = MppiSpec { samples: 2, rounds: 1, spread: 0.1, shrink: 1.0, temperature };
                let covo = CovoSpec { mppi, reach, floor: FloorSpec::Relative { share: 0.1 } }.build().unwrap();
                let hessian = covo.hessian(&objective, &mean, &mut best);
                assert_eq!(hessian.len(), 9);
                for (k, found) in hessian.iter().enumerate() {
                    let (i, j) = (k / 3, k % 3);
                    // By fractions of the box: ∂x/∂u is its side.
                    let exact = SIDES[i] * A[i][j] * SIDES[j];
                    // Costs of some tens, rounded, over the reach squared.
                    let gap = (found - exact).abs();
                    assert!(
                        gap < 100.0 * f64::EPSILON / (reach * reach) * 10.0,
                        "({i}, {j}) with {reach}, {with_slope}: off by {gap}"
                    );
                }
            }
        }
    }
}
