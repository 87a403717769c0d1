//! Training finds the truth, and how often or on how many threads it runs changes nothing.
#[path = "train/layers.rs"]
mod layers;
#[path = "train/network.rs"]
mod network;
#[path = "train/patience.rs"]
mod patience;
#[path = "train/refusals.rs"]
mod refusals;
mod toy;
use pliant::metric::{Chamfer, CostSpec};
use pliant::model::{Cost, WorldModel};
use pliant::train::{Keep, Matched, Split, TrainSpec, Trained, Unmatched, Unroll, Window};
use pliant::watch::Watch;
use std::path::Path;
use toy::Toy;

const TRUTH: [f32; 3] = [0.5, 0.8, 0.3];

fn spec() -> TrainSpec {
    TrainSpec {
        steps: 60,
        batch: 5,
        horizon: 3,
        grow: 0,
        unroll: Unroll::Whole,
        loss: None,
        rate: 0.05,
        warm_up: 5,
        last_rate: 0.01,
        turn: 0.0,
        noise: 0.0,
        clip: 1.0,
        moving: 0.5,
        motion: 1e-6,
        validation: 0.25,
        validation_windows: 6,
        validation_horizon: 4,
        validate_every: 10,
        patience: None,
        log_every: 5,
        sparsity: 0.0,
        layers: Vec::new(),
        keep: Keep::Best,
        weights: "weights".to_owned(),
        seed: 7,
    }
}

fn run(spec: &TrainSpec, model: &mut Toy, split: &Split, folder: &Path, watch: &Watch) -> anyhow::Result<Trained> {
    spec.clone().build()?.train(model, split, folder, watch)
}

/// The steps of TensorBoard's events, none of which is above 127 here: the byte behind the time and the field's tag.
fn event_steps(folder: &Path) -> Vec<u64> {
    let bytes = std::fs::read(folder.join("events.out.tfevents.pliant")).unwrap();
    let (mut rest, mut steps) = (&bytes[..], Vec::new());
    while !rest.is_empty() {
        let length = u64::from_le_bytes(rest[..8].try_into().unwrap()) as usize;
        steps.push(u64::from(rest[12 + 10]));
        rest = &rest[12 + length + 4..];
    }
    steps
}

/// Lines of `metrics.jsonl` without the time they took.
fn journal(folder: &Path) -> Vec<serde_json::Value> {
    let text = std::fs::read_to_string(folder.join("metrics.jsonl")).unwrap();
    let line = |line| {
        let mut line: serde_json::Value = serde_json::from_str(line).unwrap();
        line.as_object_mut().unwrap().shift_remove("seconds").expect("a time in every line");
        line
    };
    text.lines().map(line).collect()
}

#[test]
fn weight_gradient_of_the_matched_error_agrees_with_central_differences() {
    let episodes = toy::episodes(&Toy::new(TRUTH), 1, 6, 3);
    let window = Window::of(&episodes[0], 1, 4, &toy::tools()["pusher"]);
    let cost = Matched { targets: &window.targets, scale: 0.002 };
    let at = [0.4, 0.6, 0.1];
    let gradient = Toy::new(at).weight_gradient(&window.scene, &window.controls, &cost).unwrap().weights;
    for i in 0..3 {
        let nudged = |h: f32| {
            let mut weights = at;
            weights[i] += h;
            (f64::from(weights[i]), cost.total(&Toy::new(weights).rollout(&window.scene, &window.controls)))
        };
        let ((a, low), (b, high)) = (nudged(-1e-3), nudged(1e-3));
        let difference = (high - low) / (b - a);
        assert!(difference.abs() > 1e-3, "a difference that is trivially zero proves nothing");
        assert!((f64::from(gradient[i]) - difference).abs() < 1e-4 * difference.abs(), "weight {i}");
    }
}

#[test]
fn training_finds_the_weights_that_made_the_data() {
    let (split, folder) = (toy::split(&Toy::new(TRUTH)), tempfile::tempdir().unwrap());
    let mut model = Toy::new([0.0, 0.1, 0.0]);
    let spec = TrainSpec { steps: 400, validate_every: 100, log_every: 100, ..spec() };
    let trained = run(&spec, &mut model, &split, folder.path(), &Watch::silent()).unwrap();
    for (w, truth) in model.weights.iter().zip(TRUTH) {
        assert!((w - truth).abs() < 0.01, "{:?} instead of {TRUTH:?}", model.weights);
    }
    let held_out = trained.held_out.clone().unwrap();
    assert!(held_out.one_step < 0.02 * held_out.still_one_step, "{held_out:?}");
    let report = std::fs::read_to_string(folder.path().join("train.json")).unwrap();
    assert_eq!(serde_json::from_str::<Trained>(&report).unwrap(), trained);
}

#[test]
fn every_way_to_unroll_and_every_loss_finds_them_too() {
    let split = toy::split(&Toy::new(TRUTH));
    let distance = |kind| serde_json::from_value::<CostSpec>(serde_json::json!({ "kind": kind })).unwrap();
    let long = TrainSpec { steps: 400, validate_every: 100, log_every: 100, ..spec() };
    let ways = [
        ("grow", TrainSpec { grow: 200, ..long.clone() }),
        ("pushforward", TrainSpec { unroll: Unroll::LastStep, ..long.clone() }),
        ("chamfer", TrainSpec { loss: Some(distance("chamfer")), ..long.clone() }),
        ("sinkhorn", TrainSpec { loss: Some(distance("sinkhorn")), ..long.clone() }),
    ];
    let mut found = Vec::new();
    for (name, spec) in ways {
        let (mut model, folder) = (Toy::new([0.0, 0.1, 0.0]), tempfile::tempdir().unwrap());
        run(&spec, &mut model, &split, folder.path(), &Watch::silent()).unwrap();
        for (w, truth) in model.weights.iter().zip(TRUTH) {
            assert!((w - truth).abs() < 0.02, "{name}: {:?} instead of {TRUTH:?}", model.weights);
        }
        let judged = journal(folder.path()).iter().any(|line| line["shape"].is_number());
        assert_eq!(judged, spec.loss.is_some(), "{name}");
        found.push(model.weights);
    }
    assert!((1..found.len()).all(|k| !found[..k].contains(&found[k])), "two ways were the same: {found:?}");
}

#[test]
fn a_distance_of_shapes_does_not_know_rows_and_has_the_right_slope() {
    let episodes = toy::episodes(&Toy::new(TRUTH), 1, 6, 3);
    let window = Window::of(&episodes[0], 1, 4, &toy::tools()["pusher"]);
    let mut targets = window.targets.to_vec();
    targets.iter_mut().for_each(|x| x.positions.reverse());
    let loss = Chamfer;
    let [cost, shuffled] =
        [&window.targets[..], &targets].map(|targets| Unmatched { targets, scale: 0.002, loss: &loss });
    let at = [0.4, 0.6, 0.1];
    let total = |weights: [f32; 3], cost: &Unmatched<'_>| {
        cost.total(&Toy::new(weights).rollout(&window.scene, &window.controls))
    };
    assert!((total(at, &cost) - total(at, &shuffled)).abs() < 1e-12);
    let gradient = Toy::new(at).weight_gradient(&window.scene, &window.controls, &cost).unwrap().weights;
    for i in 0..3 {
        let nudged = |h: f32| {
            let mut weights = at;
            weights[i] += h;
            (f64::from(weights[i]), total(weights, &cost))
        };
        let ((a, low), (b, high)) = (nudged(-1e-4), nudged(1e-4));
        let difference = (high - low) / (b - a);
        assert!(difference.abs() > 1e-3, "a difference that is trivially zero proves nothing");
        assert!(
            (f64::from(gradient[i]) - difference).abs() < 1e-3 * difference.abs(),
            "weight {i}: {} {difference}",
            gradient[i]
        );
    }
}

#[test]
fn a_run_stopped_anywhere_ends_with_the_bits_of_one_that_was_not() {
    let (split, spec) = (toy::split(&Toy::new(TRUTH)), TrainSpec { noise: 1e-4, turn: 3.0, ..spec() });
    let (whole, parts) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let mut reference = Toy::new([0.0, 0.1, 0.0]);
    run(&spec, &mut reference, &split, whole.path(), &Watch::silent()).unwrap();

    let stop_after = |steps: usize| {
        let watch = Watch::silent();
        let mut model = Toy { stop: Some((watch.clone(), steps + 1)), ..Toy::new([0.0, 0.1, 0.0]) };
        let error = run(&spec, &mut model, &split, parts.path(), &watch).unwrap_err().to_string();
        assert!(error.contains("goes on"), "{error}");
    };
    stop_after(13);
    let checkpoint = parts.path().join("checkpoint.bin");
    let early = std::fs::read(&checkpoint).unwrap();
    stop_after(14);
    // As after a kill: the journal is ahead of the checkpoint and its last line is torn.
    std::fs::write(&checkpoint, early).unwrap();
    let metrics = parts.path().join("metrics.jsonl");
    let torn = std::fs::read_to_string(&metrics).unwrap() + "{\"step\":2";
    std::fs::write(&metrics, torn).unwrap();
    let mut resumed = Toy::new([0.0, 0.1, 0.0]);
    run(&spec, &mut resumed, &split, parts.path(), &Watch::silent()).unwrap();

    assert_eq!(bits(&resumed), bits(&reference));
    assert_eq!(journal(parts.path()), journal(whole.path()));
    let steps: Vec<u64> = journal(whole.path()).iter().map(|l| l["step"].as_u64().unwrap()).collect();
    assert_eq!(steps, (1..=12).map(|i| 5 * i).collect::<Vec<_>>());
    assert_eq!(event_steps(parts.path()), [vec![0], steps].concat(), "the version's event, then one a line");
}

#[test]
fn the_best_weights_of_before_a_stop_are_still_the_best_after_it() {
    let split = toy::split(&Toy::new(TRUTH));
    // From the truth, noise leads away: the first validations are the best. Which noise does is looked for.
    let noisy = |seed| TrainSpec { noise: 3e-3, last_rate: 1.0, seed, ..spec() };
    let whole = |seed| {
        let (folder, mut model) = (tempfile::tempdir().unwrap(), Toy::new(TRUTH));
        let trained = run(&noisy(seed), &mut model, &split, folder.path(), &Watch::silent()).unwrap();
        (trained.kept, bits(&model))
    };
    let (seed, (kept, weights)) = (0..20).map(|seed| (seed, whole(seed))).find(|(_, (kept, _))| *kept <= 20).unwrap();
    let (folder, watch) = (tempfile::tempdir().unwrap(), Watch::silent());
    let mut stopped = Toy { stop: Some((watch.clone(), 31)), ..Toy::new(TRUTH) };
    run(&noisy(seed), &mut stopped, &split, folder.path(), &watch).unwrap_err();
    let mut resumed = Toy::new(TRUTH);
    let trained = run(&noisy(seed), &mut resumed, &split, folder.path(), &Watch::silent()).unwrap();
    assert_eq!((trained.kept, bits(&resumed)), (kept, weights));
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let (split, spec) = (toy::split(&Toy::new(TRUTH)), TrainSpec { noise: 1e-4, turn: 3.0, ..spec() });
    let trained = |threads: usize| {
        let folder = tempfile::tempdir().unwrap();
        let mut model = Toy::new([0.0, 0.1, 0.0]);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let trained = pool.install(|| run(&spec, &mut model, &split, folder.path(), &Watch::silent())).unwrap();
        (bits(&model), trained.held_out, journal(folder.path()))
    };
    assert_eq!(trained(1), trained(2));
}

#[test]
fn noise_changes_what_is_learned_and_the_seed_what_is_drawn() {
    let split = toy::split(&Toy::new(TRUTH));
    let trained = |spec: TrainSpec| {
        let (folder, mut model) = (tempfile::tempdir().unwrap(), Toy::new([0.0, 0.1, 0.0]));
        run(&spec, &mut model, &split, folder.path(), &Watch::silent()).unwrap();
        bits(&model)
    };
    let plain = trained(spec());
    assert_ne!(plain, trained(TrainSpec { noise: 1e-3, ..spec() }));
    assert_ne!(plain, trained(TrainSpec { seed: 8, ..spec() }));
    assert_eq!(plain, trained(spec()));
}

fn bits(model: &Toy) -> Vec<u32> {
    model.weights.iter().map(|w| w.to_bits()).collect()
}
