//! Planners that follow the cost's curvature, where it is known.
use crate::field::*;
use pliant::planner::{Covariance, FloorSpec, Objective, PlannerSpec};
use pliant::problem::{Budget, Metered};
use pliant::state::{ActionSpace, stream};
use std::sync::Mutex;

/// `½ uᵀ A u` around a point off the middle, A turned out of the axes, with curvatures from 1 to 10⁴.
fn valley(with_slope: bool) -> impl Objective {
    let bend = [1.0, 30.0, 800.0, 1e4];
    // A Householder reflection, which is its own inverse.
    let mirror = [0.3, -0.5, 0.7, 0.4];
    let norm: f64 = mirror.iter().map(|m| m * m).sum();
    let reflect = move |x: &[f64]| -> Vec<f64> {
        let along: f64 = 2.0 * mirror.iter().zip(x).map(|(m, x)| m * x).sum::<f64>() / norm;
        x.iter().zip(mirror).map(|(x, m)| x - along * m).collect()
    };
    let offset = |x: &[f64]| -> Vec<f64> { x.iter().zip([0.62, 0.41, 0.55, 0.47]).map(|(x, c)| x - c).collect() };
    let slope = move |x: &[f64]| {
        let bent: Vec<f64> = reflect(&offset(x)).iter().zip(bend).map(|(y, b)| b * y).collect();
        reflect(&bent)
    };
    Field {
        space: space(&[0.0; 4], &[1.0; 4]),
        value: move |x: &[f64]| reflect(&offset(x)).iter().zip(bend).map(|(y, b)| 0.5 * b * y * y).sum(),
        slope: with_slope.then_some(slope),
    }
}

#[test]
fn along_a_narrow_valley_curvature_beats_its_price() {
    // Equal budgets: without gradients a Hessian costs 33 rollouts, with them 8 gradients at the price of 3 each.
    for (with_slope, rollouts) in [(false, 600), (true, 600)] {
        let cost = |stem: &str, seed: u64| {
            let objective = valley(with_slope);
            let metered = Metered::new(&objective, Budget { rollouts, gradient_price: 3, seconds: None }, &|| 0.0);
            // Both with samples of equal volume throughout, so that neither gains by having shrunk more often.
            let steady = "samples = 40\nrounds = 1000\nspread = 0.1\nshrink = 1.0\ntemperature = { kind = 'adapted', share = 0.2 }";
            let overrides = if stem == "covo" { format!("[mppi]\n{steady}") } else { steady.to_owned() };
            run(&named(stem, &overrides), &metered, seed).unwrap().cost
        };
        let mean = |stem: &str| (0..10).map(|seed| cost(stem, seed).ln()).sum::<f64>() / 10.0;
        let (covo, mppi) = (mean("covo"), mean("mppi"));
        assert!(covo < mppi - 0.4, "log cost {covo} against {mppi}, with slope: {with_slope}");
    }
}

/// Batches of plans that an objective was asked to cost.
struct Recorded<O>(O, Mutex<Vec<Vec<Vec<f64>>>>);

impl<O: Objective> Objective for Recorded<O> {
    fn space(&self) -> &ActionSpace {
        self.0.space()
    }
    fn costs(&self, plans: &[Vec<f64>]) -> Vec<f64> {
        self.1.lock().unwrap().push(plans.to_vec());
        self.0.costs(plans)
    }
    fn gradient(&self, plan: &[f64]) -> Option<(f64, Vec<f64>)> {
        self.0.gradient(plan)
    }
}

fn batches(spec: &PlannerSpec, objective: impl Objective) -> Vec<Vec<Vec<f64>>> {
    let recorded = Recorded(objective, Mutex::default());
    run(spec, &recorded, 7);
    recorded.1.into_inner().unwrap()
}

#[test]
fn under_equal_curvature_covo_draws_the_samples_of_mppi_bit_for_bit() {
    let round_bowl = || Field {
        space: space(&[0.0; 3], &[1.0; 3]),
        value: |x: &[f64]| x.iter().map(|x| (x - 0.4).powi(2)).sum(),
        slope: Some(|x: &[f64]| x.iter().map(|x| 2.0 * (x - 0.4)).collect::<Vec<f64>>()),
    };
    let (covo, mppi) = (batches(&named("covo", ""), round_bowl()), batches(&named("mppi", ""), round_bowl()));
    assert_eq!(covo.len(), 20);
    assert_eq!(covo, mppi);
    assert_ne!(batches(&named("covo", ""), valley(true)), batches(&named("mppi", ""), valley(true)));
}

#[test]
fn a_cold_mppi_moves_to_its_best_sample() {
    let cold = named("mppi", "temperature = { kind = 'fixed', value = 1e-12 }");
    for pair in batches(&cold, rosenbrock()).windows(2) {
        let costs = rosenbrock().costs(&pair[0]);
        let best = (0..costs.len()).min_by(|&a, &b| costs[a].total_cmp(&costs[b])).unwrap();
        let gap = pair[1][0].iter().zip(&pair[0][best]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(gap < 1e-12, "the next mean is {gap} from the best sample");
    }
}

#[test]
fn covariances_keep_their_determinant_and_stay_positive_whatever_the_hessian() {
    let mut rng = stream(3, &[4]);
    for floor in [FloorSpec::Relative { share: 1e-3 }, FloorSpec::Absolute { value: 1e-2 }] {
        for dimension in 1..6 {
            for round in 0..50 {
                // Indefinite, of any size; every tenth is not a number, or zero.
                let size = 10f64.powi(round % 9 - 4);
                let entry = |rng: &mut _| size * (rand::Rng::random::<f64>(rng) - 0.5);
                let mut hessian: Vec<f64> = (0..dimension * dimension).map(|_| entry(&mut rng)).collect();
                match round % 10 {
                    8 => hessian[0] = f64::NAN,
                    9 => hessian.fill(0.0),
                    _ => {}
                }
                let covariance = Covariance::of(&hessian, 0.3, &floor);
                let expected = 2.0 * dimension as f64 * 0.3f64.ln();
                assert!((covariance.log_determinant() - expected).abs() < 1e-10 * expected.abs());
                let unit = |k: usize| (0..dimension).map(|i| f64::from(u8::from(i == k))).collect::<Vec<_>>();
                for k in 0..dimension {
                    let length = covariance.colour(&unit(k)).iter().map(|x| x * x).sum::<f64>().sqrt();
                    assert!(length.is_finite() && length > 0.0);
                }
            }
        }
    }
    // Σ ∝ R^{-1/2}: with δ the least curvature of R itself, one 16 times as large is searched half as widely.
    let stiff = Covariance::of(&[16.0, 0.0, 0.0, 1.0], 1.0, &FloorSpec::Absolute { value: 1.0 });
    let spread = |e: [f64; 2]| stiff.colour(&e).iter().map(|x| x * x).sum::<f64>();
    let ratio = spread([1.0, 0.0]) / spread([0.0, 1.0]);
    assert!((ratio - 4.0).abs() < 1e-12 || (ratio - 0.25).abs() < 1e-12, "variances in the ratio {ratio}");
}

#[test]
fn linear_quadratic_control_agrees_with_riccati() {
    // x' = a x + b u, J = Σ (q x'² + r u²) over four steps from x = 1.
    let (a, b, q, r) = (1.1, 0.7, 1.0, 0.5);
    let states = move |u: &[f64]| {
        u.iter()
            .scan(1.0, |x, u| {
                *x = a * *x + b * u;
                Some(*x)
            })
            .collect::<Vec<f64>>()
    };
    let control = Field {
        space: space(&[-2.0; 4], &[2.0; 4]),
        value: move |u: &[f64]| states(u).iter().zip(u).map(|(x, u)| q * x * x + r * u * u).sum(),
        slope: Some(move |u: &[f64]| {
            let mut later = 0.0;
            let x = states(u);
            let mut slope: Vec<f64> = (0..4)
                .rev()
                .map(|t| {
                    later = a * later + 2.0 * q * x[t];
                    b * later + 2.0 * r * u[t]
                })
                .collect();
            slope.reverse();
            slope
        }),
    };
    // P over the steps to go, backwards: u = −(r + b² P)⁻¹ a b P x with P of the state after the step.
    let mut after = vec![q];
    for _ in 0..3 {
        let p = after[after.len() - 1];
        after.push(q + a * a * p * r / (r + b * b * p));
    }
    let mut x = 1.0;
    let optimum: Vec<f64> = after
        .iter()
        .rev()
        .map(|p| {
            let u = -a * b * p * x / (r + b * b * p);
            x = a * x + b * u;
            u
        })
        .collect();
    for (stem, overrides, close) in [
        ("lbfgs", LONG_LBFGS, 1e-7),
        ("descent", LONG_DESCENT, 1e-4),
        ("covo", "", 0.02),
        ("cem", LONG_CEM, 0.02),
        ("refine", "", 0.01),
    ] {
        let plan = run(&named(stem, overrides), &control, 2).unwrap();
        let gap = plan.theta.iter().zip(&optimum).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(gap < close, "{stem} is {gap} from Riccati's {optimum:?}: {plan:?}");
    }
}
