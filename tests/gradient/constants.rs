//! Gradients by the constants of laws against central differences.
use super::Contender;
use super::problem::{Mixed, STEPS, problem};
use pliant::model::{Cost, ModelSpec, WorldModel};
use pliant::state::Scene;
use pliant::train::{replace, value};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde_json::Value;

pub(crate) fn config(name: &str) -> Value {
    let path = format!("{}/configs/model/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let contender: Contender = toml_edit::de::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    serde_json::to_value(contender.dynamics).unwrap()
}

pub(crate) fn build(config: &Value) -> Box<dyn WorldModel> {
    serde_json::from_value::<ModelSpec>(config.clone()).unwrap().build().unwrap()
}

/// Real numbers below a value.
fn reals(value: &Value) -> usize {
    match value {
        Value::Object(map) => map.values().map(reals).sum(),
        Value::Array(items) => items.iter().map(reals).sum(),
        other => usize::from(other.is_f64()),
    }
}

/// Every constant's exact derivative against differences, as changes of J for a relative change of the constant.
pub(crate) fn check(name: &str, config: &Value) {
    let (scene, controls, cost) = problem(&mut ChaCha8Rng::seed_from_u64(7));
    let model = build(config);
    let paths = model.constants();
    let found = model.constant_gradient(&scene, &controls, &cost, STEPS).unwrap();
    let total = |config: &Value| cost.total(&build(config).rollout(&scene, &controls));
    assert!((found.cost - total(config)).abs() <= 1e-12 * found.cost.abs());
    for (path, exact) in paths.iter().zip(&found.constants) {
        let at = value(config, path).unwrap();
        let along = |h: f64| total(&replace(config, [(path.as_str(), at * (1.0 + h))]).unwrap());
        // Several steps, because a contact that just closes within one of them bends the cost there.
        let agrees = |h: f64| {
            let difference = (along(h) - along(-h)) / (2.0 * h);
            assert!(difference.abs() > 1e-7, "{name}: {path} does nothing here");
            (at * exact / difference - 1.0).abs() <= 1e-4
        };
        assert!([2e-6, 5e-7, 1e-5].into_iter().any(agrees), "{name}: {path} {}", at * exact);
    }
}

#[test]
fn derivatives_by_every_constant_agree_with_central_differences() {
    for name in ["analytic", "formula"] {
        let config = config(name);
        let paths = build(&config).constants();
        assert_eq!(paths.len(), reals(&config), "{name}: every constant has a derivative: {paths:?}");
        check(name, &config);
    }
}

#[test]
fn formulas_and_laws_in_rust_have_the_same_derivatives() {
    let (scene, controls, cost) = problem(&mut ChaCha8Rng::seed_from_u64(8));
    let [written, formulas] = ["analytic", "formula"].map(|name| {
        let model = build(&config(name));
        let by = model.constant_gradient(&scene, &controls, &cost, STEPS).unwrap().constants;
        model.constants().into_iter().zip(by).collect::<std::collections::BTreeMap<_, _>>()
    });
    assert_eq!(written.keys().collect::<Vec<_>>(), formulas.keys().collect::<Vec<_>>());
    for (path, a) in &written {
        assert!((a / formulas[path] - 1.0).abs() < 1e-6, "{path}: {a} and {}", formulas[path]);
    }
}

#[test]
fn a_truncated_gradient_is_the_sum_of_those_of_its_pieces() {
    let (scene, controls, Mixed(rows)) = problem(&mut ChaCha8Rng::seed_from_u64(9));
    let model = build(&config("analytic"));
    let by = |scene: &Scene, from: usize, to: usize, truncation: usize| {
        let cost = Mixed(rows[from..=to].to_vec());
        model.constant_gradient(scene, &controls[from..to], &cost, truncation).unwrap().constants
    };
    let middle = model.rollout(&scene, &controls)[2].clone();
    let later = Scene { particles: middle, poses: controls[1].poses.clone(), ..scene.clone() };
    let (cut, whole) = (by(&scene, 0, 4, 2), by(&scene, 0, 4, 4));
    let pieces: Vec<f64> = by(&scene, 0, 2, 9).iter().zip(by(&later, 2, 4, 9)).map(|(a, b)| a + b).collect();
    let close = |a: f64, b: f64| (a - b).abs() <= 1e-9 * a.abs().max(b.abs());
    assert!(cut.iter().zip(&pieces).all(|(a, b)| close(*a, *b)), "{cut:?}\n{pieces:?}");
    assert!(!cut.iter().zip(&whole).all(|(a, b)| close(*a, *b)), "what happened before a cut matters");
}

#[test]
fn what_has_no_derivative_is_not_named() {
    assert_eq!(build(&config("learned")).constants(), ["keep"]);
    assert!(build(&serde_json::json!({"kind": "still"})).constants().is_empty());
}
