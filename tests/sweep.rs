//! A sweep runs every trial once, whatever is killed or crashes in between.
use pliant::config::{load, write_whole};
use pliant::sweep::{Outcome, SweepSpec, collect, freeze, launch, run};
use pliant::watch::Watch;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use tempfile::TempDir;

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct TrialSpec {
    samples: usize,
    #[serde(default)]
    seeds: Vec<u64>,
    #[serde(default)]
    title: String,
}

/// Writes one row and counts its runs in `ran` of the sweep's folder.
const CHILD: &str = r#"out=${2#out=}; echo "$out" >> "$out/../ran"; echo "{\"cost\": 1.5}" > "$out/rows.jsonl""#;

struct Bench {
    folder: TempDir,
}

impl Bench {
    fn new() -> Self {
        let bench = Self { folder: TempDir::new().unwrap() };
        write_whole(&bench.base(), b"samples = 1\nseeds = [0]\n").unwrap();
        bench
    }

    fn base(&self) -> PathBuf {
        self.folder.path().join("configs/compare/base.toml")
    }

    /// A sweep of four trials over a child written in shell.
    fn spec(&self, child: &str) -> SweepSpec {
        let file = self.folder.path().join("configs/sweep/grid.toml");
        let (base, out) = (self.base().display().to_string(), self.folder.path().join("out").display().to_string());
        let text = format!("base = \"{base}\"\nout = \"{out}\"\nseeds = [1, 2]\n[grid]\nsamples = [10, 20]\n");
        write_whole(&file, text.as_bytes()).unwrap();
        let command = ["sh", "-c", child, "child"].map(str::to_owned).to_vec();
        SweepSpec { command, ..load::<SweepSpec>(&file, &[]).unwrap().spec }
    }

    fn run(&self, spec: &SweepSpec) -> Outcome {
        run::<TrialSpec>(spec, &Watch::silent()).unwrap()
    }
}

fn runs(outcome: &Outcome) -> usize {
    fs::read_to_string(outcome.folder.join("ran")).unwrap_or_default().lines().count()
}

fn wait_for(path: &Path) {
    for _ in 0..1000 {
        if path.exists() {
            return;
        }
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    panic!("{} never came", path.display());
}

#[test]
fn all_configs_are_frozen_before_the_first_trial_and_each_runs_once() {
    let bench = Bench::new();
    // the child fails unless it sees the frozen configs of all four trials, and holds the lock itself
    let checks =
        r#"[ $(ls "${2#out=}"/../*/config.toml | wc -l) = 4 ] && [ /dev/stdin -ef "${2#out=}/lock" ] || exit 9"#;
    let child = format!("{checks}; {CHILD}");
    let spec = SweepSpec { jobs: 2, ..bench.spec(&child) };
    let first = bench.run(&spec);
    assert_eq!((first.done, first.failed.len(), runs(&first)), (4, 0, 4));
    let configs: Vec<TrialSpec> = freeze::<TrialSpec>(&spec)
        .unwrap()
        .trials
        .iter()
        .map(|trial| load::<TrialSpec>(&trial.config(), &[]).unwrap().spec)
        .collect();
    let seen: Vec<(usize, &[u64])> = configs.iter().map(|config| (config.samples, &config.seeds[..])).collect();
    assert_eq!(seen, [(10, &[1][..]), (10, &[2]), (20, &[1]), (20, &[2])]);
    let second = bench.run(&SweepSpec { jobs: 1, ..spec.clone() });
    assert_eq!((second.done, runs(&second)), (4, 4));
    assert_eq!(first.folder, second.folder);
}

#[test]
fn an_interrupted_sweep_runs_only_what_is_missing() {
    let bench = Bench::new();
    let spec = bench.spec(CHILD);
    let frozen = freeze::<TrialSpec>(&spec).unwrap();
    fs::write(frozen.trials[1].result(), "{\"cost\": 7}\n").unwrap();
    let outcome = bench.run(&spec);
    assert_eq!((outcome.done, runs(&outcome)), (4, 3));
    let rows = collect(&outcome.folder).unwrap();
    let costs: Vec<f64> = rows.iter().map(|row| row["cost"].as_f64().unwrap()).collect();
    assert_eq!(costs, [1.5, 7.0, 1.5, 1.5]);
    assert_eq!((&rows[2]["samples"], &rows[2]["seeds"]), (&20.into(), &serde_json::json!([1])));
    assert_eq!(rows[2]["change"], "samples=20");
}

#[test]
fn a_crash_is_recorded_and_the_rest_go_on_and_it_is_tried_again() {
    let bench = Bench::new();
    let broken = bench.folder.path().join("broken");
    fs::write(&broken, "").unwrap();
    // while the marker is there, trials of 20 samples leave half a result and crash
    let child = format!(
        r#"if [ -e "{}" ] && grep -q "samples = 20" "$1"; then echo half > "${{2#out=}}/rows.jsonl"; echo first; echo "no luck" >&2; exit 3; fi; {CHILD}"#,
        broken.display()
    );
    let spec = SweepSpec { jobs: 2, ..bench.spec(&child) };
    let outcome = bench.run(&spec);
    assert_eq!((outcome.done, outcome.failed.len(), runs(&outcome)), (2, 2, 2));
    let failure: serde_json::Value =
        serde_json::from_slice(&fs::read(outcome.failed[0].join("failure.json")).unwrap()).unwrap();
    assert_eq!((&failure["code"], &failure["log"]), (&3.into(), &serde_json::json!(["first", "no luck"])));
    assert_eq!(collect(&outcome.folder).unwrap().len(), 2);
    fs::remove_file(&broken).unwrap();
    let outcome = bench.run(&spec);
    assert_eq!((outcome.done, outcome.failed.len(), runs(&outcome)), (4, 0, 4));
    assert!(!outcome.folder.join("failure.json").exists());
    assert_eq!(collect(&outcome.folder).unwrap().len(), 4);
}

#[test]
fn a_child_that_ends_without_a_result_or_cannot_start_has_failed() {
    let bench = Bench::new();
    let silent = bench.run(&bench.spec("true"));
    let failure = fs::read_to_string(silent.failed[0].join("failure.json")).unwrap();
    assert!(silent.failed.len() == 4 && failure.contains("without writing"), "{failure}");
    let command = vec!["/nonexistent/program".to_owned()];
    let absent = bench.run(&SweepSpec { command, ..bench.spec("") });
    let failure = fs::read_to_string(absent.failed[0].join("failure.json")).unwrap();
    assert!(failure.contains("cannot start `/nonexistent/program`"), "{failure}");
}

#[test]
fn two_sweeps_at_once_share_the_trials() {
    let bench = Bench::new();
    let spec = SweepSpec { jobs: 2, ..bench.spec(&format!("sleep 0.1; {CHILD}")) };
    let frozen = freeze::<TrialSpec>(&spec).unwrap();
    let outcomes = std::thread::scope(|scope| {
        let sweeps = [(); 3].map(|()| scope.spawn(|| launch(&frozen, 2, &Watch::silent()).unwrap()));
        sweeps.map(|sweep| sweep.join().unwrap())
    });
    assert!(frozen.trials.iter().all(|trial| trial.done()));
    assert_eq!(runs(&outcomes[0]), 4);
}

#[test]
fn a_trial_stays_locked_while_the_child_of_a_killed_sweep_runs_and_no_longer() {
    let bench = Bench::new();
    let spec = SweepSpec { seeds: vec![1], grid: [].into(), ..bench.spec(CHILD) };
    let trial = &freeze::<TrialSpec>(&spec).unwrap().trials[0];
    // what a killed sweep leaves: a child whose standard input is the locked file, and nobody else
    let lock = fs::File::create(trial.folder.join("lock")).unwrap();
    lock.lock().unwrap();
    let mut orphan = Command::new("sleep").arg("60").stdin(Stdio::from(lock)).spawn().unwrap();
    let busy = bench.run(&spec);
    assert_eq!((busy.done, busy.elsewhere, runs(&busy)), (0, 1, 0));
    orphan.kill().unwrap();
    orphan.wait().unwrap();
    let free = bench.run(&spec);
    assert_eq!((free.done, free.elsewhere, runs(&free)), (1, 0, 1));
}

#[test]
fn after_a_stop_no_trial_starts_and_the_running_one_is_waited_for() {
    let bench = Bench::new();
    let spec = bench.spec(&format!(r#"touch "${{2#out=}}/../begun"; sleep 0.3; {CHILD}"#));
    let watch = Watch::silent();
    let folder = freeze::<TrialSpec>(&spec).unwrap().folder;
    let outcome = std::thread::scope(|scope| {
        let sweep = scope.spawn(|| run::<TrialSpec>(&spec, &watch).unwrap());
        wait_for(&folder.join("begun"));
        watch.stop();
        sweep.join().unwrap()
    });
    assert_eq!((outcome.done, outcome.left, runs(&outcome)), (1, 3, 1));
}

#[test]
fn a_wrong_trial_stops_the_sweep_before_anything_is_written() {
    let bench = Bench::new();
    let spec = SweepSpec { changes: vec![vec!["sampels=3".to_owned()]], ..bench.spec(CHILD) };
    let error = format!("{:#}", run::<TrialSpec>(&spec, &Watch::silent()).unwrap_err());
    assert!(error.contains("unknown key `sampels`") && error.contains("trial `samples=10 sampels=3"), "{error}");
    assert!(!spec.out.exists());
    let empty = SweepSpec { grid: [("samples".to_owned(), vec![])].into(), ..bench.spec(CHILD) };
    let error = run::<TrialSpec>(&empty, &Watch::silent()).unwrap_err().to_string();
    assert!(error.contains("`grid.samples`"), "{error}");
    assert!(collect(&spec.out).unwrap_err().to_string().contains("is not the folder of a sweep"));
}

#[test]
fn the_same_config_written_twice_is_one_trial() {
    let bench = Bench::new();
    let changes = vec![vec!["samples=10".to_owned()], vec!["title=\"\"".to_owned()]];
    let outcome = bench.run(&SweepSpec { changes, ..bench.spec(CHILD) });
    // grid of 2, times baseline and two changes that change nothing or make it 10, times 2 seeds: only 4 differ
    assert_eq!((outcome.done, runs(&outcome)), (4, 4));
}
