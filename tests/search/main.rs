//! Searches over the box of constants: each finds what it should, and none asks for more than it may.
mod cones;
use pliant::train::search::{
    GaussianProcess, Misfit, SearchSpec, Slope, Squares, Start, Tried, at, constants, expected_improvement,
    least_within, place,
};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::json;
use std::sync::atomic::{AtomicUsize, Ordering};

const BOUNDS: [[f64; 2]; 3] = [[0.1, 10.0], [1.0, 1e4], [1e-3, 1e-1]];
const TRUTH: [f64; 3] = [0.4, 300.0, 0.02];

/// Residuals that are smooth functions of the constants relative to the truth, `r = A (ln c − ln c*) + curve`.
struct Smooth {
    asked: AtomicUsize,
    linear: Linear,
}

/// Whether residuals are linear in the constants themselves.
#[derive(Clone, Copy, PartialEq)]
enum Linear {
    Yes,
    No,
}

const MIX: [[f64; 3]; 4] = [[1.0, 0.3, -0.2], [0.2, 0.8, 0.5], [-0.4, 0.1, 1.1], [0.3, -0.6, 0.4]];

impl Smooth {
    fn new(linear: Linear) -> Self {
        Self { asked: AtomicUsize::new(0), linear }
    }

    fn constants(point: &[f64]) -> Vec<f64> {
        constants(point, &BOUNDS)
    }

    /// Residuals, and their derivative by relative changes of the constants.
    fn residuals(&self, point: &[f64]) -> (Vec<f64>, Vec<[f64; 3]>) {
        let c = Self::constants(point);
        let ratio: Vec<f64> = c.iter().zip(TRUTH).map(|(c, t)| c / t).collect();
        let (value, slope): (Vec<f64>, Vec<f64>) = match self.linear {
            Linear::Yes => ratio.iter().map(|q| (q - 1.0, *q)).unzip(),
            Linear::No => ratio.iter().map(|q| (q.ln() + 0.02 * q.ln().powi(3), 1.0 + 0.06 * q.ln().powi(2))).unzip(),
        };
        let row = |m: &[f64; 3]| (0..3).map(|k| m[k] * value[k]).sum();
        (MIX.iter().map(row).collect(), MIX.iter().map(|m| [0, 1, 2].map(|k| m[k] * slope[k])).collect())
    }
}

impl Misfit for Smooth {
    fn bounds(&self) -> Vec<[f64; 2]> {
        BOUNDS.to_vec()
    }

    fn cost(&self, point: &[f64]) -> f64 {
        self.asked.fetch_add(1, Ordering::Relaxed);
        assert!(point.iter().all(|u| (0.0..=1.0).contains(u)), "{point:?} leaves the box");
        self.residuals(point).0.iter().map(|r| r * r).sum()
    }

    fn slope(&self, point: &[f64], _: usize) -> Option<Slope> {
        let squares = self.squares(point)?;
        let wide = |k: usize| 2.0 * squares.slope[k] * (BOUNDS[k][1] / BOUNDS[k][0]).ln();
        Some(Slope { cost: squares.cost, slope: (0..3).map(wide).collect() })
    }

    fn squares(&self, point: &[f64]) -> Option<Squares> {
        self.asked.fetch_add(1, Ordering::Relaxed);
        let (r, jacobian) = self.residuals(point);
        let slope = (0..3).map(|k| r.iter().zip(&jacobian).map(|(r, j)| r * j[k]).sum()).collect();
        let curvature = (0..9).map(|n| jacobian.iter().map(|j| j[n / 3] * j[n % 3]).sum()).collect();
        Some(Squares { cost: r.iter().map(|r| r * r).sum(), slope, curvature })
    }
}

fn start(seed: u64) -> Start {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    Start { point: (0..3).map(|_| rng.random()).collect(), sigma: 0.2, seed, evaluations: 240 }
}

/// The lowest cost that a search finds and what it spent.
fn lowest(search: serde_json::Value, misfit: &Smooth, start: &Start) -> (f64, usize, Vec<f64>) {
    let folder = tempfile::tempdir().unwrap();
    let tried = Tried::new(misfit, folder.path(), "smooth").unwrap();
    let search: SearchSpec = serde_json::from_value(search).unwrap();
    search.build().unwrap().search(start, &tried, &mut |_| Ok(())).unwrap();
    let found = tried.best().unwrap();
    (found.cost, found.evaluations, Smooth::constants(&found.point))
}

const KINDS: [&str; 5] = ["cma", "bayesian", "gradient", "cma_then_gradient", "least_squares"];

#[test]
fn every_search_beats_random_points_at_equal_evaluations() {
    for seed in 0..3 {
        let (random, spent, _) = lowest(json!({"kind": "random"}), &Smooth::new(Linear::No), &start(seed));
        assert_eq!(spent, 240);
        for kind in KINDS {
            let (cost, spent, _) = lowest(json!({ "kind": kind }), &Smooth::new(Linear::No), &start(seed));
            assert!(cost < 0.5 * random, "{kind}, seed {seed}: {cost} beside {random} at random");
            assert!(spent <= 240, "{kind} spent {spent}");
        }
    }
}

#[test]
fn what_is_linear_in_the_constants_is_solved_for_at_once() {
    let misfit = Smooth::new(Linear::Yes);
    // Room for one design matrix and one look at what it gives.
    let start = Start { evaluations: 2 * 3 + 5 + 1, ..start(1) };
    let (cost, spent, constants) = lowest(json!({"kind": "least_squares"}), &misfit, &start);
    assert_eq!((spent, misfit.asked.load(Ordering::Relaxed)), (12, 2));
    assert!(cost < 1e-16, "{cost}");
    assert!(constants.iter().zip(TRUTH).all(|(c, t)| (c / t - 1.0).abs() < 1e-7), "{constants:?}");
}

#[test]
fn a_stopped_search_goes_on_without_asking_twice() {
    for kind in KINDS.iter().chain(&["random"]) {
        let (folder, misfit) = (tempfile::tempdir().unwrap(), Smooth::new(Linear::No));
        let spec: SearchSpec = serde_json::from_value(json!({ "kind": kind })).unwrap();
        let (search, start) = (spec.build().unwrap(), Start { evaluations: 60, ..start(4) });
        let tried = Tried::new(&misfit, folder.path(), "smooth").unwrap();
        let mut rounds = 0;
        let stop = search.search(&start, &tried, &mut |_| {
            rounds += 1;
            tried.save()?;
            if rounds == 2 { anyhow::bail!("enough") } else { Ok(()) }
        });
        assert!(stop.is_err(), "{kind} has no second round");
        let asked = misfit.asked.load(Ordering::Relaxed);
        let tried = Tried::new(&misfit, folder.path(), "smooth").unwrap();
        search.search(&start, &tried, &mut |_| Ok(())).unwrap();
        let resumed = tried.best().unwrap();

        let (other, fresh) = (tempfile::tempdir().unwrap(), Smooth::new(Linear::No));
        let again = Tried::new(&fresh, other.path(), "smooth").unwrap();
        search.search(&start, &again, &mut |_| Ok(())).unwrap();
        assert_eq!(again.best().unwrap(), resumed, "{kind}");
        assert!(asked > 0 && misfit.asked.load(Ordering::Relaxed) == fresh.asked.load(Ordering::Relaxed), "{kind}");
        assert!(Tried::new(&misfit, folder.path(), "another").is_err(), "memories of other runs are refused");
    }
}

#[test]
fn a_box_without_reach_changes_nothing_and_one_with_it_binds() {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    for _ in 0..20 {
        let rows: Vec<Vec<f64>> = (0..7).map(|_| (0..3).map(|_| rng.random_range(-1.0..1.0)).collect()).collect();
        let size = [1.0, 1e3, 1e-2];
        let hessian: Vec<f64> =
            (0..9).map(|n| rows.iter().map(|r| r[n / 3] * r[n % 3]).sum::<f64>() * size[n / 3] * size[n % 3]).collect();
        let slope: Vec<f64> = (0..3).map(|k| size[k] * rng.random_range(-1.0..1.0)).collect();
        let gradient = |d: &[f64]| -> Vec<f64> {
            (0..3).map(|i| slope[i] + (0..3).map(|j| hessian[3 * i + j] * d[j]).sum::<f64>()).collect()
        };
        let free = least_within(&hessian, &slope, &[[-1e9, 1e9]; 3], &[]).unwrap();
        // The normal equations hold.
        assert!(gradient(&free).iter().zip(&slope).zip(size).all(|((g, _), s)| (g / s).abs() < 1e-6), "{free:?}");
        let room: Vec<[f64; 2]> = size.iter().map(|s| [-0.1 / s, 0.2 / s]).collect();
        let bound = least_within(&hessian, &slope, &room, &[]).unwrap();
        let mut active = 0;
        for (k, by) in gradient(&bound).into_iter().enumerate() {
            let [low, high] = room[k];
            assert!((low..=high).contains(&bound[k]));
            let width = high - low;
            // Karush, Kuhn and Tucker: flat inside, downhill only across a bound.
            match (bound[k] - low < 1e-6 * width, high - bound[k] < 1e-6 * width) {
                (true, _) => assert!(by / size[k] > -1e-6),
                (_, true) => assert!(by / size[k] < 1e-6),
                _ => assert!((by / size[k]).abs() < 1e-5, "{by}"),
            }
            active += usize::from(bound[k] - low < 1e-6 * width || high - bound[k] < 1e-6 * width);
        }
        assert!(active > 0, "some bound is active in a small box");
    }
    assert!(least_within(&[f64::NAN], &[1.0], &[[-1.0, 1.0]], &[]).is_err());
}

#[test]
fn a_gaussian_process_goes_through_its_data_and_knows_where_it_has_none() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let points: Vec<Vec<f64>> = (0..40).map(|_| vec![rng.random(), rng.random()]).collect();
    let f = |p: &[f64]| 3.0 + 20.0 * (4.0 * p[0]).sin();
    let values: Vec<f64> = points.iter().map(|p| f(p)).collect();
    let process = GaussianProcess::new(points.clone(), &values, vec![0.4; 2]);
    for (point, value) in points.iter().zip(&values) {
        let (mean, deviation) = process.predict(point);
        assert!((mean - value).abs() < 1e-2 && deviation < 1e-1, "{mean} ± {deviation} for {value}");
    }
    // What does not matter has a longer length, and between points the process is nearly right.
    assert!(process.lengths()[1] > 2.0 * process.lengths()[0], "{:?}", process.lengths());
    let (mean, _) = process.predict(&[0.5, 0.5]);
    assert!((mean - f(&[0.5, 0.5])).abs() < 0.5, "{mean}");
    let near = GaussianProcess::with(points, &values, vec![0.05; 2]);
    let mean = values.iter().sum::<f64>() / 40.0;
    let scatter = (values.iter().map(|y| (y - mean).powi(2)).sum::<f64>() / 40.0).sqrt();
    let far = near.predict(&[9.0, 9.0]);
    assert!(
        (far.0 - mean).abs() < 1e-9 && (far.1 / scatter - 1.0).abs() < 1e-9,
        "far away it knows the scatter: {far:?}"
    );
}

#[test]
fn expected_improvement_is_what_integration_gives() {
    for (mean, deviation, best) in [(0.0, 1.0, 0.0), (2.0, 0.5, 1.0), (-1.0, 2.0, 3.0), (1.0, 0.3, 1.2)] {
        let density = |z: f64| (-0.5 * z * z).exp() / (2.0 * std::f64::consts::PI).sqrt();
        let (count, half) = (200_000, 10.0);
        let step = 2.0 * half / f64::from(count);
        let midpoint = |k: i32| -half + (f64::from(k) + 0.5) * step;
        let gain = |z: f64| (best - (mean + deviation * z)).max(0.0) * density(z) * step;
        let integral: f64 = (0..count).map(|k| gain(midpoint(k))).sum();
        let found = expected_improvement(mean, deviation, best);
        assert!((found - integral).abs() < 1e-7, "{found} against {integral}");
    }
    assert_eq!(expected_improvement(1.0, 0.0, 3.0), 2.0);
    assert_eq!(expected_improvement(3.0, 0.0, 1.0), 0.0);
}

#[test]
fn places_of_constants_and_back() {
    for (c, bounds) in [(3.0, [1.0, 9.0]), (2e4, [2e3, 2e5])] {
        assert!((place(c, bounds) - 0.5).abs() < 1e-12 && (at(0.5, bounds) / c - 1.0).abs() < 1e-12);
    }
    assert_eq!((place(1e9, [1.0, 2.0]), at(0.0, [1.0, 2.0])), (1.0, 1.0));
}

#[test]
fn impossible_searches_are_refused() {
    let refusal = |spec: serde_json::Value| {
        let error = serde_json::from_value::<SearchSpec>(spec).unwrap().build().err().expect("a refusal");
        error.to_string()
    };
    assert!(refusal(json!({"kind": "gradient", "rate": 0.0})).contains("`rate`"));
    assert!(refusal(json!({"kind": "gradient", "truncation": 0})).contains("leave it out"));
    assert!(refusal(json!({"kind": "cma_then_gradient", "share": 1.5})).contains("`share`"));
    assert!(refusal(json!({"kind": "least_squares", "price": 0})).contains("`price`"));
    assert!(refusal(json!({"kind": "bayesian", "candidates": 0})).contains("`candidates`"));
    assert!(serde_json::from_value::<SearchSpec>(json!({"kind": "gradient", "speed": 1})).is_err());
}
