//! What a dataset holds out: sizes, tools, materials and starts that no fit sees, and the same episodes whatever the split.
use pliant::config::{self, fingerprint};
use pliant::data::{DatasetSpec, HELD_OUT, Info, SplitSpec, check, record, simulate};
use pliant::watch::Watch;
use std::path::Path;

fn load(words: &[&str]) -> Result<DatasetSpec, config::ConfigError> {
    let words: Vec<String> = words.iter().map(|w| (*w).to_owned()).collect();
    Ok(config::load("configs/dataset/smoke.toml".as_ref(), &words)?.spec)
}

/// Six quick episodes, changed.
fn spec(overrides: &[&str]) -> DatasetSpec {
    load(&[&["steps=3", "scene.solver.steps=1"], overrides].concat()).unwrap()
}

fn refusal(overrides: &[&str], folder: &Path) -> String {
    format!("{:#}", simulate(&spec(overrides), folder, &Watch::silent()).unwrap_err())
}

/// Splits as configs name them: parts of `configs/split`.
const BY_MATERIAL: [&str; 3] = ["+split=material", "+material=[dough,clay]", "episodes=6"];

#[test]
fn the_default_split_is_not_written_and_changes_no_fingerprint() {
    let plain = spec(&[]);
    let json = serde_json::to_value(&plain).unwrap();
    for key in ["split", "material", "start"] {
        assert!(json[key].is_null(), "`{key}` is written: every fingerprint of a dataset would change");
    }
    assert_eq!(fingerprint(&spec(&["+split=episode"])), fingerprint(&plain));
    assert_ne!(fingerprint(&spec(&["+split=size"])), fingerprint(&plain));
}

#[test]
fn every_material_and_start_meets_every_tool_and_the_last_is_held_out() {
    let folder = tempfile::tempdir().unwrap();
    let words = [&BY_MATERIAL[..], &["+start=[block,ellipsoid]", "episodes=12", "scene.particles=40"]].concat();
    let dataset = simulate(&spec(&words), folder.path(), &Watch::silent()).unwrap();
    let mut met: Vec<_> = dataset.metadata.episodes.iter().map(|e| (&e.tool, &e.material, &e.start)).collect();
    assert!(met[0].1.as_deref() == Some("dough") && met[0].2.as_deref() == Some("block"), "{met:?}");
    met.sort();
    met.dedup();
    assert_eq!(met.len(), 12, "all of three tools, two materials and two starts");

    let (train, held_out) = dataset.split(HELD_OUT);
    assert_eq!((train.len(), held_out.len()), (6, 6));
    let material = |theta: &[f64]| {
        let entry = dataset.metadata.episodes.iter().find(|e| e.theta == theta).unwrap();
        entry.material.clone().unwrap()
    };
    assert!(train.iter().all(|e| material(&e.theta) == "dough"));
    assert!(held_out.iter().all(|e| material(&e.theta) == "clay"));
    assert_eq!(dataset.metadata.num_trajs_test, 6);
    assert_eq!(check(folder.path()).unwrap().faults, [""; 0]);
    let info = Info::of(folder.path()).unwrap();
    assert_eq!((info.materials["clay"], info.starts["ellipsoid"], info.split), (6, 6, spec(&words).split));

    // One episode alone is the one among many, and its material matters: the same seed in dough ends elsewhere.
    let (among, plain) = (spec(&words), spec(&["scene.particles=40", "+start=[block,ellipsoid]", "episodes=12"]));
    assert_eq!(record(&among, 3).unwrap(), dataset.episodes[3]);
    let (clay, dough) = (&dataset.episodes[3], record(&plain, 3).unwrap());
    assert_ne!(clay.states[3], dough.states[3]);
}

#[test]
fn a_tool_is_held_out_by_name_and_another_split_keeps_the_episodes() {
    let folder = tempfile::tempdir().unwrap();
    let even = simulate(&spec(&[]), folder.path(), &Watch::silent()).unwrap();
    let time = |name: &str| std::fs::metadata(folder.path().join(name)).unwrap().modified().unwrap();
    let before = time("episode_00000.npz");
    let by_tool = spec(&["+split=tool", "+split.held_out=[gripper_rod]"]);
    let dataset = simulate(&by_tool, folder.path(), &Watch::silent()).unwrap();
    assert_eq!((time("episode_00000.npz"), &dataset.episodes), (before, &even.episodes));
    let (train, held_out) = dataset.split(HELD_OUT);
    assert!(held_out.len() == 2 && held_out.iter().all(|e| e.tool == "gripper_rod"));
    assert!(train.len() == 4 && train.iter().all(|e| e.tool != "gripper_rod"));
    assert_eq!(check(folder.path()).unwrap().faults, [""; 0]);

    let by_size = simulate(&spec(&["+split=size"]), folder.path(), &Watch::silent()).unwrap();
    let (train, held_out) = by_size.split(HELD_OUT);
    assert_eq!((train.len(), held_out.len()), (4, 2));
    // Blocks of the quickstart are not turned: their boxes tell their volumes, up to the particles that stand for them.
    let volume = |e: &&pliant::data::Episode| {
        let points = &e.states[0].positions;
        let (low, high) = points.iter().fold((points[0], points[0]), |(l, h), p| (l.min(*p), h.max(*p)));
        (high - low).element_product()
    };
    let (most, least) = (train.iter().map(volume).fold(0.0, f64::max), held_out.iter().map(volume).fold(1.0, f64::min));
    assert!(least > 0.97 * most, "a training scene of {most} m³ is larger than a held-out one of {least} m³");
}

#[test]
fn splits_that_leave_nothing_are_refused_with_the_key() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path().join("dataset");
    let said = |words: &[&str]| refusal(words, &here);
    assert!(said(&["+split=material"]).contains("`material` lists nothing"));
    assert!(said(&["+split=tool", "+split.held_out=[hammer]"]).contains("names \"hammer\""));
    let all = "+split.held_out=[gripper_rod,press_square,roller_large]";
    assert!(said(&["+split=tool", all]).contains("leave one"));
    assert!(said(&[&BY_MATERIAL[..2], &["episodes=3"]].concat()).contains("at least 6"));
    assert!(said(&["+split={kind=given}"]).contains("imported"));
    assert!(!here.exists(), "a refused dataset leaves a folder");
    assert!(load(&["+split={kind=frame}"]).is_err(), "there is no split by frame");
    assert_eq!(SplitSpec::default(), spec(&["+split=episode"]).split);
}

#[test]
fn twenty_minutes_are_what_they_say() {
    let load = |words: &[&str]| {
        let words: Vec<String> = words.iter().map(|w| (*w).to_owned()).collect();
        config::load::<DatasetSpec>("configs/dataset/twenty_minutes.toml".as_ref(), &words).unwrap().spec
    };
    for spec in [load(&[]), load(&["tool=[knife]", "episodes=800"])] {
        let seconds = (spec.episodes * spec.steps) as f64 * spec.scene.interval;
        let each = seconds / spec.tool.len() as f64;
        assert!((each - 1200.0).abs() < 1e-9 && spec.episodes % spec.tool.len() == 0, "{each} s a tool");
    }
    assert_eq!(load(&["tool=[knife]"]).tool.keys().collect::<Vec<_>>(), ["knife"]);
}
