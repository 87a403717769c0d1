//! Training that ends where its validations no longer improve.
use super::toy::{self, Toy};
use super::{TRUTH, bits, journal, run, spec};
use pliant::train::{Keep, Split, TrainSpec, Trained};
use pliant::watch::Watch;
use std::path::Path;

const PATIENCE: u64 = 3;

/// From the truth, noise leads to and fro: the best validation comes early, and later ones are of any size.
fn wandering(patience: Option<u64>) -> TrainSpec {
    TrainSpec { steps: 600, noise: 3e-3, last_rate: 1.0, patience, ..spec() }
}

fn trained(spec: &TrainSpec, split: &Split, folder: &Path) -> (Trained, Vec<u32>) {
    let mut model = Toy::new(TRUTH);
    let trained = run(spec, &mut model, split, folder, &Watch::silent()).unwrap();
    (trained, bits(&model))
}

#[test]
fn training_ends_after_as_many_validations_that_were_no_better_than_the_best() {
    let (split, whole, cut) =
        (toy::split(&Toy::new(TRUTH)), tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    assert_eq!(trained(&wandering(None), &split, whole.path()).0.steps, 600, "without patience it never ends early");
    let (ended, _) = trained(&wandering(Some(PATIENCE)), &split, cut.path());

    let lines = journal(whole.path());
    let errors: Vec<(u64, f64)> =
        lines.iter().filter_map(|l| Some((l["step"].as_u64()?, l["rollout"].as_f64()?))).collect();
    let lowest = |until: usize| errors[..until].iter().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap().0;
    let worse = |i: usize| errors[..=i].iter().rev().take_while(|(step, _)| *step > lowest(i + 1)).count();
    let last = (0..errors.len()).find(|i| worse(*i) as u64 == PATIENCE).expect("the toy wanders");
    assert_eq!((ended.steps, ended.kept), (errors[last].0, lowest(last + 1)));
    assert!(ended.kept > 10, "the best validation was not the first, so that improving has begun the count anew");

    let mut short = journal(cut.path());
    let reason =
        short.last_mut().unwrap().as_object_mut().unwrap().shift_remove("stopped").expect("the last line says why");
    let reason = reason.as_str().unwrap();
    assert!(reason.contains(&format!("step {}", ended.kept)) && reason.contains("3 in a row"), "{reason}");
    assert_eq!(short, lines[..short.len()], "until then nothing is another");
    assert!(lines.iter().all(|line| line.get("stopped").is_none()), "a run to its last step has nothing to say");
}

#[test]
fn a_run_stopped_anywhere_ends_where_one_that_was_not_does() {
    let split = toy::split(&Toy::new(TRUTH));
    for keep in [Keep::Best, Keep::Last] {
        let spec = TrainSpec { keep, ..wandering(Some(PATIENCE)) };
        let whole = tempfile::tempdir().unwrap();
        let reference = trained(&spec, &split, whole.path());
        let end = reference.0.steps;
        for stop in [7, end - 25, end - 10, end - 1] {
            let (folder, watch) = (tempfile::tempdir().unwrap(), Watch::silent());
            let mut model = Toy { stop: Some((watch.clone(), stop as usize + 1)), ..Toy::new(TRUTH) };
            run(&spec, &mut model, &split, folder.path(), &watch).unwrap_err();
            let resumed = trained(&spec, &split, folder.path());
            assert_eq!((resumed.0.steps, resumed.0.kept), (end, reference.0.kept), "stopped after {stop}");
            assert_eq!(resumed.1, reference.1, "stopped after {stop}");
            assert_eq!(journal(folder.path()), journal(whole.path()), "stopped after {stop}");
        }
        // As after a kill between the last checkpoint and the report: there is nothing left to do.
        let again = trained(&spec, &split, whole.path());
        assert_eq!((again.0.steps, again.1), (end, reference.1));
    }
}

#[test]
fn patience_without_validations_is_refused() {
    let refusal = |spec: TrainSpec| spec.build().unwrap_err().to_string();
    let patient = || wandering(Some(PATIENCE));
    for (spec, key) in [
        (TrainSpec { validation_windows: 0, ..patient() }, "`validation_windows` = 0"),
        (TrainSpec { validation: 0.0, ..patient() }, "`validation` = 0"),
        (wandering(Some(0)), "`patience` of the training config is 0"),
    ] {
        let sentence = refusal(spec);
        assert!(sentence.contains("`patience`") && sentence.contains(key), "{sentence}");
    }
    let (mut split, folder) = (toy::split(&Toy::new(TRUTH)), tempfile::tempdir().unwrap());
    split.train.truncate(1);
    let refused = run(&patient(), &mut Toy::new(TRUTH), &split, folder.path(), &Watch::silent()).unwrap_err();
    assert!(refused.to_string().contains("set aside to validate on"), "{refused}");
}

#[test]
fn a_config_without_patience_reads_as_it_did_and_has_the_fingerprint_that_it_had() {
    let text = serde_json::to_string(&wandering(None)).unwrap();
    assert!(!text.contains("patience"), "{text}");
    let patient = serde_json::to_string(&wandering(Some(PATIENCE))).unwrap();
    assert_eq!(serde_json::from_str::<TrainSpec>(&patient).unwrap(), wandering(Some(PATIENCE)));
    assert_eq!(serde_json::from_str::<TrainSpec>(&text).unwrap(), wandering(None));
}
