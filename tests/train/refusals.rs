//! What cannot be trained, or cannot go on, is refused with a sentence and loses nothing.
use super::toy::{self, Toy};
use super::{TRUTH, run, spec};
use pliant::metric::CostSpec;
use pliant::train::{Split, TrainSpec};
use pliant::watch::Watch;

#[test]
fn a_loss_that_is_not_finite_stops_with_step_and_episodes_and_keeps_the_files() {
    let (split, folder) = (toy::split(&Toy::new(TRUTH)), tempfile::tempdir().unwrap());
    let mut model = Toy::new([0.0, f32::NAN, 0.0]);
    let error = run(&spec(), &mut model, &split, folder.path(), &Watch::silent()).unwrap_err().to_string();
    assert!(error.contains("step 1") && error.contains("episodes"), "{error}");
    assert!(!folder.path().join("checkpoint.bin").exists());
}

#[test]
fn a_loss_without_a_gradient_is_refused() {
    let share: CostSpec =
        serde_json::from_value(serde_json::json!({ "kind": "missed", "of": { "kind": "coverage" } })).unwrap();
    let sentence = TrainSpec { loss: Some(share), ..spec() }.build().unwrap_err().to_string();
    assert!(sentence.contains("`loss`") && sentence.contains("gradient"), "{sentence}");
}

#[test]
fn a_checkpoint_that_is_damaged_or_not_ours_is_refused_and_left_alone() {
    let (split, folder) = (toy::split(&Toy::new(TRUTH)), tempfile::tempdir().unwrap());
    let start = || Toy::new([0.0, 0.1, 0.0]);
    run(&spec(), &mut start(), &split, folder.path(), &Watch::silent()).unwrap();
    let checkpoint = folder.path().join("checkpoint.bin");
    let whole = std::fs::read(&checkpoint).unwrap();

    let other = TrainSpec { rate: 0.01, ..spec() };
    let error = run(&other, &mut start(), &split, folder.path(), &Watch::silent()).unwrap_err().to_string();
    assert!(error.contains("checkpoint.bin belongs to"), "{error}");
    assert_eq!(std::fs::read(&checkpoint).unwrap(), whole);

    std::fs::write(&checkpoint, &whole[..whole.len() / 2]).unwrap();
    let error = run(&spec(), &mut start(), &split, folder.path(), &Watch::silent()).unwrap_err();
    assert!(format!("{error:#}").contains("damaged"), "{error:#}");
}

#[test]
fn data_that_cannot_be_used_is_named() {
    let good = toy::split(&Toy::new(TRUTH));
    let fails = |change: &dyn Fn(&mut Split)| {
        let (mut split, folder) = (good.clone(), tempfile::tempdir().unwrap());
        change(&mut split);
        let error = run(&spec(), &mut Toy::new(TRUTH), &split, folder.path(), &Watch::silent()).unwrap_err();
        format!("{error:#}")
    };
    let sentences = [
        (fails(&|s| s.train.clear()), "no particle"),
        (fails(&|s| s.train[2].states[3].positions[1].x = f64::NAN), "episode 2"),
        (fails(&|s| s.train[1].tool = "spoon".into()), "\"spoon\""),
        (fails(&|s| s.train[0].controls.truncate(2)), "7 states and 2 controls"),
    ];
    for (sentence, part) in sentences {
        assert!(sentence.contains(part), "{sentence}");
    }
}
