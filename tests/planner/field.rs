//! Functions on a box, and planners from their configs.
use pliant::planner::{Objective, Plan, PlannerSpec};
use pliant::state::{ActionSpace, stream};

/// A function on a box, its gradient where it has one.
pub(crate) struct Field<F, G> {
    pub(crate) space: ActionSpace,
    pub(crate) value: F,
    pub(crate) slope: Option<G>,
}

impl<F: Fn(&[f64]) -> f64 + Sync, G: Fn(&[f64]) -> Vec<f64> + Sync> Objective for Field<F, G> {
    fn space(&self) -> &ActionSpace {
        &self.space
    }
    fn costs(&self, plans: &[Vec<f64>]) -> Vec<f64> {
        assert!(plans.iter().all(|p| self.space.contains(p)), "a plan left the box");
        plans.iter().map(|p| (self.value)(p)).collect()
    }
    fn gradient(&self, plan: &[f64]) -> Option<(f64, Vec<f64>)> {
        assert!(self.space.contains(plan), "a plan left the box");
        self.slope.as_ref().map(|slope| ((self.value)(plan), slope(plan)))
    }
}

pub(crate) fn space(low: &[f64], high: &[f64]) -> ActionSpace {
    let names = (0..low.len()).map(|i| format!("theta{i}")).collect();
    ActionSpace { names, low: low.to_vec(), high: high.to_vec() }
}

/// `Σ wᵢ (θᵢ − cᵢ)²` with coordinates of very different widths; the last centre lies beyond the box.
pub(crate) fn bowl() -> impl Objective {
    let (centre, weight) = ([0.013, -1.1, 300.0], [1e4, 1.0, 1e-4]);
    Field {
        space: space(&[-0.02, -3.0, -100.0], &[0.03, 2.0, 200.0]),
        value: move |x: &[f64]| (0..3).map(|i| weight[i] * (x[i] - centre[i]).powi(2)).sum::<f64>(),
        slope: Some(move |x: &[f64]| (0..3).map(|i| 2.0 * weight[i] * (x[i] - centre[i])).collect::<Vec<f64>>()),
    }
}

pub(crate) fn rosenbrock() -> impl Objective {
    Field {
        space: space(&[-2.0, -1.0], &[2.0, 3.0]),
        value: |x: &[f64]| (1.0 - x[0]).powi(2) + 100.0 * (x[1] - x[0] * x[0]).powi(2),
        slope: Some(|x: &[f64]| {
            let valley = x[1] - x[0] * x[0];
            vec![-2.0 * (1.0 - x[0]) - 400.0 * x[0] * valley, 200.0 * valley]
        }),
    }
}

pub(crate) fn named(stem: &str, overrides: &str) -> PlannerSpec {
    let path = format!("{}/configs/planner/{stem}.toml", env!("CARGO_MANIFEST_DIR"));
    let mut table: toml_edit::DocumentMut = std::fs::read_to_string(path).unwrap().parse().unwrap();
    for (key, value) in overrides.parse::<toml_edit::DocumentMut>().unwrap().iter() {
        assert!(table.contains_key(key));
        table[key] = value.clone();
    }
    toml_edit::de::from_document(table).unwrap()
}

pub(crate) fn run(spec: &PlannerSpec, objective: &dyn Objective, seed: u64) -> Option<Plan> {
    spec.clone().build().unwrap().plan(objective, &mut stream(seed, &[1]))
}

/// Every planner of `configs/planner` that needs nothing learned, those among them that need a gradient, and those that need
/// proposals.
pub(crate) const ALL: [&str; 8] = ["random", "grid", "cem", "mppi", "covo", "descent", "lbfgs", "refine"];
pub(crate) const BY_PROPOSAL: [&str; 2] = ["policy", "policy_refine"];
pub(crate) const BY_GRADIENT: [&str; 3] = ["descent", "lbfgs", "refine"];

pub(crate) const LONG_LBFGS: &str = "steps = 400";
pub(crate) const LONG_CEM: &str =
    "samples = 100\nfewest = 100\nrounds = 60\nelites = 10\npatience = 20\ntolerance = 0.0\nsmoothing = 0.3";
pub(crate) const LONG_DESCENT: &str = "steps = 4000\nlast_rate = 1e-5\nmomentum = 0.9\nmemory = 0.999";
