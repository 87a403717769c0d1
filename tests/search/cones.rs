//! Constants that are bound to each other: programs in cones, and searches that keep to them.
use super::{BOUNDS, KINDS, Linear, Smooth, start};
use pliant::train::search::{Cone, Misfit, SearchSpec, Slope, Squares, Start, Tried, least_within, place};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::json;

/// The point of `{|x| ≤ t}` nearest to (t, x) (Boyd & Vandenberghe 2004, exercise 8.3c).
fn nearest([t, x, y]: [f64; 3]) -> [f64; 3] {
    let length = x.hypot(y);
    let half = 0.5 * (length + t);
    match () {
        () if length <= t => [t, x, y],
        () if length <= -t => [0.0; 3],
        () => [half, half * x / length, half * y / length],
    }
}

#[test]
fn a_cone_binds_where_its_nearest_point_is() {
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    let cone = Cone { axis: 1, of: vec![0, 2], factor: 2.0 };
    for _ in 0..50 {
        // In units in which the cone is the standard one the distance is the Euclidean: c = (x, t/2, y).
        let [x, t, y]: [f64; 3] = std::array::from_fn(|_| rng.random_range(0.1..3.0));
        let constants: [f64; 3] = std::array::from_fn(|_| rng.random_range(0.5..2.0));
        let weight = [constants[0], 2.0 * constants[1], constants[2]];
        let wanted: Vec<f64> = [x, t, y].iter().zip(weight).map(|(to, w)| to / w - 1.0).collect();
        let hessian: Vec<f64> = (0..9).map(|n| if n % 4 == 0 { weight[n / 4].powi(2) } else { 0.0 }).collect();
        let slope: Vec<f64> = (0..3).map(|k| -hessian[4 * k] * wanted[k]).collect();
        let found = least_within(&hessian, &slope, &[[-0.99, 1e9]; 3], &[cone.rows(&constants)]).unwrap();
        let moved: Vec<f64> = found.iter().zip(weight).map(|(d, w)| w * (1.0 + d)).collect();
        let [t, x, y] = nearest([t, x, y]);
        for (found, known) in moved.iter().zip([x, t, y]) {
            assert!((found - known).abs() < 1e-6, "{moved:?} instead of {:?}", [x, t, y]);
        }
        let changed: Vec<f64> = found.iter().zip(constants).map(|(d, c)| c * (1.0 + d)).collect();
        assert!(cone.holds(&changed));
    }
}

/// [`Smooth`] with its truth outside of a cone.
struct Within(Smooth, Cone);

impl Misfit for Within {
    fn bounds(&self) -> Vec<[f64; 2]> {
        self.0.bounds()
    }
    fn cones(&self) -> &[Cone] {
        std::slice::from_ref(&self.1)
    }
    fn cost(&self, point: &[f64]) -> f64 {
        assert!(self.1.holds(&Smooth::constants(point)), "asked outside of the cone");
        self.0.cost(point)
    }
    fn slope(&self, point: &[f64], truncation: usize) -> Option<Slope> {
        self.0.slope(point, truncation)
    }
    fn squares(&self, point: &[f64]) -> Option<Squares> {
        self.0.squares(point)
    }
}

#[test]
fn no_search_leaves_a_cone_and_least_squares_finds_the_best_within() {
    // The second constant at most 500 times the first, of which the truth has 750 times.
    let cone = Cone { axis: 0, of: vec![1], factor: 500.0 };
    let misfit = Within(Smooth::new(Linear::Yes), cone.clone());
    let inside = |c: [f64; 3]| [0, 1, 2].map(|k| place(c[k], BOUNDS[k])).to_vec();
    let start = Start { point: inside([1.0, 100.0, 0.01]), ..start(1) };
    let mut best = f64::INFINITY;
    for kind in KINDS.iter().chain(&["random"]).rev() {
        let folder = tempfile::tempdir().unwrap();
        let tried = Tried::new(&misfit, folder.path(), "within").unwrap();
        let search: SearchSpec = serde_json::from_value(json!({ "kind": kind })).unwrap();
        search.build().unwrap().search(&start, &tried, &mut |_| Ok(())).unwrap();
        let found = tried.best().unwrap();
        assert!(cone.holds(&Smooth::constants(&found.point)), "{kind}");
        if *kind == "least_squares" {
            best = found.cost;
            let c = Smooth::constants(&found.point);
            assert!((c[1] / (500.0 * c[0]) - 1.0).abs() < 1e-5, "the cone binds: {c:?}");
        } else {
            assert!(found.cost >= (1.0 - 1e-6) * best || *kind == "random", "{kind}: {} below {best}", found.cost);
        }
    }
}
