//! Folders of episodes: what they say of themselves, and how damage to them is found.
use pliant::config;
use pliant::data::{Dataset, DatasetSpec, Info, check, simulate};
use pliant::watch::Watch;
use std::path::Path;
use std::process::Command;

fn spec(overrides: &[&str]) -> DatasetSpec {
    let all = [&["episodes=6", "steps=4", "scene.solver.steps=1"], overrides].concat();
    let words: Vec<String> = all.iter().map(|w| (*w).to_owned()).collect();
    config::load("configs/dataset/smoke.toml".as_ref(), &words).unwrap().spec
}

fn made(overrides: &[&str]) -> (tempfile::TempDir, Dataset) {
    let folder = tempfile::tempdir().unwrap();
    let dataset = simulate(&spec(overrides), folder.path(), &Watch::silent()).unwrap();
    (folder, dataset)
}

fn faults(folder: &Path) -> Vec<String> {
    check(folder).unwrap().faults
}

#[test]
fn info_counts_what_is_there_and_names_what_does_not_read() {
    let (folder, dataset) = made(&[]);
    let info = Info::of(folder.path()).unwrap();
    assert_eq!((info.episodes, info.steps, info.particles), (6, [4, 4], [144, 144]));
    assert_eq!((info.train, info.held_out), (3, 3));
    assert!((info.minutes - 6.0 * 4.0 * 0.1 / 60.0).abs() < 1e-12, "{}", info.minutes);
    assert_eq!(info.tools.len(), 3);
    for (name, tool) in &info.tools {
        assert_eq!(tool.episodes, 2);
        for episode in dataset.episodes.iter().filter(|e| e.tool == *name) {
            let inside = |(x, [low, high]): (&f64, &[f64; 2])| low <= x && x <= high;
            assert!(episode.theta.iter().zip(&tool.theta).all(inside) && episode.theta.len() == tool.theta.len());
        }
    }
    assert_eq!(info.statistics, dataset.metadata.statistics);
    assert_eq!(info.displacement.counts.iter().sum::<u64>(), 6 * 4 * 144);
    let text = info.to_text();
    for words in ["6: 3 to learn from, 3 held out", "press_square: 2 episodes", "unreadable   0", "█"] {
        assert!(text.contains(words), "{words} in\n{text}");
    }

    // NumPy would read this file without a word; its positions are not numbers.
    let path = folder.path().join("episode_00002.npz");
    let program = "
import sys, numpy as np
a = dict(np.load(sys.argv[1])); a['positions'][2, 5, 1] = np.nan; np.savez(sys.argv[1], **a)";
    let run = Command::new("python3").args(["-c", program]).arg(&path).status();
    if !run.is_ok_and(|status| status.success()) {
        std::fs::write(&path, "not finite").unwrap();
        eprintln!("skipped the number that is not finite: there is no python3 with numpy");
    }
    let info = Info::of(folder.path()).unwrap();
    assert_eq!((info.episodes, info.unreadable.len()), (5, 1));
    assert!(info.unreadable[0].contains("episode_00002.npz"), "{:?}", info.unreadable);
    assert!(info.to_text().contains(&info.unreadable[0]));
    assert!(format!("{:#}", Info::of(&folder.path().join("nowhere")).unwrap_err()).contains("holds no dataset"));
}

#[test]
fn every_kind_of_damage_is_found_and_named() {
    let (folder, _) = made(&[]);
    let at = |name: &str| folder.path().join(name);
    assert_eq!(faults(folder.path()), [""; 0]);
    assert_eq!(check(folder.path()).unwrap().hashed, Some(6 + 2));
    assert!(check(folder.path()).unwrap().verdict().unwrap().contains("6 episodes"));

    // One bit anywhere in any file.
    for (name, place) in [("episode_00001.npz", 11), ("episode_00004.npz", 5000), ("dataset.toml", 3)] {
        let whole = std::fs::read(at(name)).unwrap();
        let mut bytes = whole.clone();
        bytes[place] ^= 1;
        std::fs::write(at(name), bytes).unwrap();
        let found = check(folder.path()).map_or_else(|e| vec![format!("{e:#}")], |c| c.faults);
        assert!(found.iter().any(|f| f.contains(name)), "{name}: {found:?}");
        std::fs::write(at(name), whole).unwrap();
    }

    let whole = std::fs::read(at("episode_00003.npz")).unwrap();
    std::fs::remove_file(at("episode_00003.npz")).unwrap();
    let found = faults(folder.path());
    assert!(found.len() == 1 && found[0].contains("episode_00003.npz is missing; simulate again"), "{found:?}");
    // Another episode's file is whole, and yet not this one.
    std::fs::copy(at("episode_00000.npz"), at("episode_00003.npz")).unwrap();
    assert!(faults(folder.path()).iter().any(|f| f.contains("episode_00003.npz is not the file")));
    std::fs::write(at("episode_00003.npz"), whole).unwrap();
    std::fs::write(at("episode_00077.npz"), "mine").unwrap();
    let found = faults(folder.path());
    assert!(found.len() == 1 && found[0].contains("episode_00077.npz is no episode"), "{found:?}");
    std::fs::remove_file(at("episode_00077.npz")).unwrap();

    // Without hashes, as older folders are, what the metadata says is still compared with the spec and the episodes.
    std::fs::remove_file(at("SHA256SUMS")).unwrap();
    let old = check(folder.path()).unwrap();
    assert!(old.verdict().unwrap().contains("no SHA256SUMS"));
    let metadata = std::fs::read_to_string(at("metadata.json")).unwrap();
    for (from, to, key) in
        [("\"dt\": 0.1", "\"dt\": 0.2", "dt"), ("\"seed\": 1,\n  \"spec\"", "\"seed\": 2,\n  \"spec\"", "seed")]
    {
        assert!(metadata.contains(from), "{from}");
        std::fs::write(at("metadata.json"), metadata.replacen(from, to, 1)).unwrap();
        let found = faults(folder.path());
        assert!(found.len() == 1 && found[0].contains(&format!("`{key}`")), "{found:?}");
    }
    std::fs::copy(at("episode_00000.npz"), at("episode_00003.npz")).unwrap();
    std::fs::write(at("metadata.json"), &metadata).unwrap();
    assert!(faults(folder.path()).iter().any(|f| f.contains("`episodes`")), "another episode in its place");

    // Simulating again mends what does not read, but cannot know of whole files that are not its own: those are removed first.
    std::fs::remove_file(at("episode_00003.npz")).unwrap();
    simulate(&spec(&[]), folder.path(), &Watch::silent()).unwrap();
    assert_eq!(faults(folder.path()), [""; 0]);
}

#[test]
fn sha256sum_agrees_with_the_hashes() {
    let (folder, _) = made(&["episodes=3"]);
    let sums = || Command::new("sha256sum").args(["-c", "--strict", "SHA256SUMS"]).current_dir(folder.path()).output();
    let Ok(good) = sums() else { return eprintln!("skipped: there is no sha256sum") };
    assert!(good.status.success(), "{}", String::from_utf8_lossy(&good.stderr));
    assert_eq!(String::from_utf8_lossy(&good.stdout).lines().count(), 3 + 2);
    std::fs::write(folder.path().join("metadata.json"), "{}").unwrap();
    assert!(!sums().unwrap().status.success());
}

#[test]
fn the_program_says_what_it_found_and_fails_on_any_fault() {
    let (folder, _) = made(&["episodes=3"]);
    let pliant = |words: &[&str]| {
        Command::new(env!("CARGO_BIN_EXE_pliant")).arg("data").args(words).arg(folder.path()).output().unwrap()
    };
    let out = |output: &std::process::Output| String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(out(&pliant(&["info"])).contains("episodes     3"));
    let json: serde_json::Value = serde_json::from_str(&out(&pliant(&["info", "--json"]))).unwrap();
    assert_eq!(json["tools"]["gripper_rod"]["episodes"], 1);
    assert!(out(&pliant(&["check"])).contains("3 episodes read"));
    std::fs::write(folder.path().join("episode_00001.npz"), "damaged").unwrap();
    let bad = pliant(&["check"]);
    let words = String::from_utf8_lossy(&bad.stderr).into_owned();
    assert!(
        bad.status.code() == Some(2) && words.contains("1 fault:") && words.contains("episode_00001.npz"),
        "{words}"
    );
}
