//! Identification finds the constants that made the data, and says what it found.
mod toy;
use pliant::model::WorldModel;
use pliant::train::search::SearchSpec;
use pliant::train::{ConeSpec, Identification, IdentifySpec, Split, value};
use pliant::watch::Watch;
use serde_json::{Value, json};
use std::path::Path;
use toy::Toy;

const TRUTH: [f32; 3] = [0.5, 0.8, 0.3];

/// A config of the toy: constants of laws, all real.
fn config(weights: [f64; 3]) -> Value {
    json!({"kind": "toy", "laws": [
        {"kind": "drag", "keep": weights[0]},
        {"kind": "push", "gain": weights[1]},
        {"kind": "lift", "strength": weights[2]},
    ]})
}

fn build(config: &Value) -> anyhow::Result<Box<dyn WorldModel>> {
    let weight = |path: &str| value(config, path).map(|w| w as f32);
    Ok(Box::new(Toy::new([weight("laws.drag.keep")?, weight("laws.push.gain")?, weight("laws.lift.strength")?])))
}

fn spec() -> IdentifySpec {
    IdentifySpec {
        cones: Vec::new(),
        leave_out: Vec::new(),
        constants: [
            ("laws.drag.keep".to_owned(), [0.01, 1.0]),
            ("laws.push.gain".to_owned(), [0.05, 5.0]),
            ("laws.lift.strength".to_owned(), [0.01, 10.0]),
        ]
        .into_iter()
        .collect(),
        evaluations: 500,
        windows: 10,
        horizon: 4,
        motion: 1e-6,
        sigma: 0.2,
        seed: 3,
        search: SearchSpec::default(),
        starts: 1,
    }
}

fn run(spec: &IdentifySpec, model: &Value, folder: &Path, watch: &Watch) -> anyhow::Result<(Value, Identification)> {
    let split: Split = toy::split(&Toy::new(TRUTH));
    spec.clone().build()?.identify(model, &build, &split, folder, watch)
}

#[test]
fn the_constants_that_made_the_data_are_recovered() {
    let folder = tempfile::tempdir().unwrap();
    let start = config([0.1, 4.0, 0.02]);
    let (fitted, report) = run(&spec(), &start, folder.path(), &Watch::silent()).unwrap();
    for ((path, constant), truth) in report.constants.iter().zip(TRUTH.map(f64::from)) {
        assert!((constant.after / truth - 1.0).abs() < 0.02, "{path}: {constant:?} instead of {truth}");
        assert_eq!(value(&fitted, path).unwrap(), constant.after);
    }
    let held_out = report.held_out.clone().unwrap();
    assert!(held_out.after.unwrap() < 0.02 * held_out.before.unwrap(), "{held_out:?}");
    assert!(report.train.after.unwrap() < 0.02 * report.train.still && report.evaluations <= 500);

    let text = std::fs::read_to_string(folder.path().join("identify.json")).unwrap();
    assert_eq!(serde_json::from_str::<Identification>(&text).unwrap(), report);
    let lines = std::fs::read_to_string(folder.path().join("metrics.jsonl")).unwrap();
    let best: Vec<f64> =
        lines.lines().map(|l| serde_json::from_str::<Value>(l).unwrap()["error"].as_f64().unwrap()).collect();
    assert!(best.len() > 10 && best.windows(2).all(|b| b[1] <= b[0]), "the best so far never gets worse");
}

#[test]
fn neither_threads_nor_a_stop_change_the_result() {
    let spec = IdentifySpec { evaluations: 60, ..spec() };
    let found = |threads: usize, stopped: bool| {
        let folder = tempfile::tempdir().unwrap();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let start = config([0.1, 4.0, 0.02]);
            if stopped {
                let watch = Watch::silent();
                watch.stop();
                let error = run(&spec, &start, folder.path(), &watch).unwrap_err().to_string();
                assert!(error.contains("goes on"), "{error}");
                assert!(!folder.path().join("identify.json").exists());
            }
            let (fitted, report) = run(&spec, &start, folder.path(), &Watch::silent()).unwrap();
            (fitted, Identification { seconds: 0.0, ..report })
        })
    };
    let reference = found(1, false);
    assert_eq!(reference, found(2, false));
    assert_eq!(reference, found(2, true));
}

#[test]
fn a_start_outside_the_bounds_is_moved_onto_them_and_never_made_worse() {
    let spec = IdentifySpec { evaluations: 40, ..spec() };
    let folder = tempfile::tempdir().unwrap();
    let (_, report) = run(&spec, &config([0.5, 0.8, 50.0]), folder.path(), &Watch::silent()).unwrap();
    assert_eq!(report.constants["laws.lift.strength"].before, 50.0);
    assert!(report.constants.values().all(|c| c.low <= c.after && c.after <= c.high));
    assert!(report.train.after.unwrap() < report.train.before.unwrap());
}

#[test]
fn impossible_requests_are_answered_with_the_way_out() {
    let folder = tempfile::tempdir().unwrap();
    let fails = |change: &dyn Fn(&mut IdentifySpec)| {
        let mut spec = spec();
        change(&mut spec);
        let start = config([0.1, 4.0, 0.02]);
        format!("{:#}", run(&spec, &start, folder.path(), &Watch::silent()).unwrap_err())
    };
    let rename = |s: &mut IdentifySpec| {
        s.constants.insert("laws.push.gian".into(), [0.1, 1.0]);
    };
    assert!(fails(&rename).contains("did you mean `laws.push.gain`?"));
    assert!(fails(&|s| s.constants[0] = [0.0, 1.0]).contains("0 < low < high"));
    assert!(fails(&|s| s.constants.clear()).contains("name at least one"));
    assert!(fails(&|s| s.starts = 0).contains("`starts`"));
    let gradient = |s: &mut IdentifySpec| s.search = serde_json::from_value(json!({"kind": "gradient"})).unwrap();
    assert!(fails(&gradient).contains("no derivative by `laws.drag.keep`"), "{}", fails(&gradient));
    assert!(fails(&|s| s.horizon = 50).contains("fewer than the 50"));
}

#[test]
fn several_starts_share_the_evaluations_and_the_first_is_the_models_own() {
    let folder = tempfile::tempdir().unwrap();
    let spec = IdentifySpec { evaluations: 120, starts: 3, ..spec() };
    let (_, report) = run(&spec, &config([0.1, 4.0, 0.02]), folder.path(), &Watch::silent()).unwrap();
    assert!((90..=120).contains(&report.evaluations), "{}", report.evaluations);
    let alone = tempfile::tempdir().unwrap();
    let one = IdentifySpec { evaluations: 40, starts: 1, ..spec };
    let (_, first) = run(&one, &config([0.1, 4.0, 0.02]), alone.path(), &Watch::silent()).unwrap();
    assert!(report.train.after <= first.train.after, "{:?} and {:?}", report.train, first.train);
}

#[test]
fn the_report_says_how_sensitive_the_error_is() {
    let folder = tempfile::tempdir().unwrap();
    let (fitted, report) = run(&spec(), &config([0.1, 4.0, 0.02]), folder.path(), &Watch::silent()).unwrap();
    let after = report.train.after.unwrap();
    let found = report.constants.values().map(|c| c.after).collect::<Vec<_>>();
    for (k, (path, constant)) in report.constants.iter().enumerate() {
        assert_eq!(value(&fitted, path).unwrap(), found[k]);
        let [less, more] = constant.beside.map(|e| e.expect("a finite error"));
        assert!(less.max(more) > after, "{path}: {constant:?} beside {after}");
    }
    let of = |k: usize| report.constants[k].beside[1].unwrap();
    assert!(of(1) > 2.0 * of(2), "the push matters more than the lift: {:?}", report.constants);
}

#[test]
fn constants_keep_to_their_cones_and_a_start_outside_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    // The truth itself lies outside: drag is less than twice the lift then, whatever the data say.
    let cone = ConeSpec { within: "laws.lift.strength".into(), of: vec!["laws.drag.keep".into()], factor: 1e-2 };
    let factor = f64::from(0.5 * TRUTH[0] / TRUTH[2]);
    let within = |factor| IdentifySpec { cones: vec![ConeSpec { factor, ..cone.clone() }], ..spec() };
    let start = config([0.011, 4.0, 9.0]);
    let (_, report) = run(&within(factor), &start, folder.path(), &Watch::silent()).unwrap();
    let (drag, lift) = (report.constants["laws.drag.keep"].after, report.constants["laws.lift.strength"].after);
    assert!(drag <= (1.0 + 1e-6) * factor * lift && drag > 0.9 * factor * lift, "{drag} beside {lift}: the cone binds");
    assert!(report.train.after < report.train.before);
    let refused = run(&within(1e-6), &start, folder.path(), &Watch::silent()).unwrap_err().to_string();
    assert!(refused.contains("laws.lift.strength") && refused.contains("outside"), "{refused}");
    let unknown = ConeSpec { within: "laws.lift".into(), ..cone };
    let refused = IdentifySpec { cones: vec![unknown], ..spec() }.build().err().unwrap().to_string();
    assert!(refused.contains("laws.lift") && refused.contains("laws.push.gain"), "{refused}");
}
