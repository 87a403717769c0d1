//! Datasets: made in any order, killed, resumed, refused, and read by others.
use pliant::data::{Dataset, DatasetSpec, record, simulate};
use pliant::tool::Workpiece;
use pliant::watch::Watch;
use std::collections::BTreeMap;
use std::path::Path;

/// Coarse dough: data, not physics, is tested here.
const SCENE: &str = "
spacing = 0.014
particles = 40
interval = 0.1
[scene.start]
kind = 'block'
x = [0.05, 0.07]
y = [0.05, 0.07]
z = [0.025, 0.035]
turn = [0.0, 1.5]
[scene.material]
kind = 'dough'
density = 1200.0
young_modulus = 2e4
poisson_ratio = 0.499
damping_ratio = 1.0
yield_strain = 0.02
creep_rate = 60.0
largest_set = 0.8
friction = 0.5
[scene.solver]
steps = 3
substeps = 2
sweeps = 2
";

fn spec(episodes: usize, seed: u64) -> DatasetSpec {
    let mut text = format!("episodes = {episodes}\nseed = {seed}\nsteps = 6\n[scene]\n{SCENE}");
    for tool in ["gripper_rod", "press_square", "roller_large"] {
        let config = std::fs::read_to_string(format!("configs/tool/{tool}.toml")).unwrap();
        let (keys, head) = config.split_at(config.find('[').unwrap());
        let head =
            head.replace("[head", &format!("[tool.{tool}.head")).replace("[finger", &format!("[tool.{tool}.finger"));
        text += &format!("\n[tool.{tool}]\n{keys}{head}");
    }
    toml_edit::de::from_str(&text).unwrap()
}

fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path());
    entries.map(|p| (p.file_name().unwrap().to_string_lossy().into_owned(), std::fs::read(&p).unwrap())).collect()
}

fn sentence<T>(result: anyhow::Result<T>) -> String {
    format!("{:#}", result.err().expect("an error"))
}

#[test]
fn a_killed_run_goes_on_and_ends_with_the_same_bytes_on_any_number_of_threads() {
    let (spec, whole, killed) = (spec(6, 1), tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let on = |threads: usize, folder: &Path| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| simulate(&spec, folder, &Watch::silent())).unwrap()
    };
    let dataset = on(1, whole.path());
    let expected = files(whole.path());
    assert_eq!(expected.len(), 6 + 4, "{:?}", expected.keys());

    // What a kill leaves: some files not there, one half written beside its place, no metadata.
    on(3, killed.path());
    assert_eq!(files(killed.path()), expected);
    let at = |name: &str| killed.path().join(name);
    for name in ["episode_00001.npz", "episode_00004.npz", "metadata.json"] {
        std::fs::remove_file(at(name)).unwrap();
    }
    std::fs::write(at(".episode_00001.npz.1.tmp"), &expected["episode_00001.npz"][..100]).unwrap();
    std::fs::write(at("episode_00005.npz"), &expected["episode_00005.npz"][..100]).unwrap();
    assert!(sentence(Dataset::load(killed.path())).contains("not finished"));
    let resumed = on(2, killed.path());
    assert_eq!(files(killed.path()), expected);
    assert_eq!(resumed.episodes, dataset.episodes);

    let loaded = Dataset::load(killed.path()).unwrap();
    assert_eq!(loaded.episodes, dataset.episodes);
    assert_eq!(loaded.tools.keys().collect::<Vec<_>>(), ["gripper_rod", "press_square", "roller_large"]);
    for (k, episode) in loaded.episodes.iter().enumerate() {
        assert_eq!(record(&spec, k).unwrap(), *episode, "episode {k} differs when it is made alone");
    }

    // Another spec may not take the folder, and leaves it as it was.
    let other = DatasetSpec { seed: 2, ..spec.clone() };
    assert!(sentence(simulate(&other, killed.path(), &Watch::silent())).contains("another spec"));
    assert_eq!(files(killed.path()), expected);
    let moved = loaded.episodes.iter().map(|e| e.states[0].positions[0]).collect::<Vec<_>>();
    assert!((1..6).all(|k| moved[k] != moved[0]), "episodes start alike: {moved:?}");
    check_metadata(&loaded, whole.path());
}

fn check_metadata(dataset: &Dataset, folder: &Path) {
    let text = std::fs::read_to_string(folder.join("metadata.json")).unwrap();
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    let lagrangebench = "case solver dim dx dt t_end write_every sequence_length_train num_trajs_train \
        sequence_length_test num_trajs_test num_particles_max periodic_boundary_conditions bounds \
        default_connectivity_radius vel_mean vel_std acc_mean acc_std";
    for key in lagrangebench.split_whitespace() {
        assert!(!json[key].is_null(), "metadata.json lacks `{key}`");
    }
    assert_eq!(json["sequence_length_train"], 6);
    assert_eq!(json["num_trajs_train"].as_u64().unwrap() + json["num_trajs_test"].as_u64().unwrap(), 6);
    assert_eq!(json["episodes"][4]["tool"], "press_square");
    let statistics = dataset.metadata.statistics;
    assert!(statistics.displacement > 1e-4 && statistics.displacement < 0.05, "{statistics:?}");
    for state in dataset.episodes.iter().flat_map(|e| &e.states) {
        for p in &state.positions {
            assert!((0..3).all(|i| dataset.metadata.bounds[i][0] <= p[i] && p[i] <= dataset.metadata.bounds[i][1]));
        }
    }
}

#[test]
fn episodes_are_actions_of_their_tools_with_velocities_that_are_backward_differences() {
    let spec = spec(3, 5);
    for k in 0..3 {
        let episode = record(&spec, k).unwrap();
        let tool = spec.tool[&episode.tool].clone().build().unwrap();
        let piece = Workpiece::around(&episode.states[0]);
        // The recorded start is rounded to float32, the workpiece that the action was drawn for is not.
        let mut inside = episode.theta.clone();
        tool.space(&piece).clamp(&mut inside);
        assert!(inside.iter().zip(&episode.theta).all(|(a, b)| (a - b).abs() < 1e-7), "{inside:?} {:?}", episode.theta);
        let motion = tool.motion(&episode.theta, &piece, spec.steps);
        for (a, b) in motion.controls.iter().zip(&episode.controls) {
            assert!(a.poses.iter().zip(&b.poses).all(|(a, b)| a.translation.distance(b.translation) < 1e-7));
        }
        for pair in episode.states.windows(2) {
            for i in 0..pair[0].len() {
                let step = pair[1].positions[i] - pair[0].positions[i];
                assert!((step - episode.interval * pair[1].velocities[i]).length() < 1e-15);
            }
        }
        let p = episode.states[3].positions[1];
        assert_eq!(p, p.as_vec3().as_dvec3(), "positions are float32 numbers");
    }
}

#[test]
fn a_stopped_run_says_so_and_a_missing_folder_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let watch = Watch::silent();
    watch.stop();
    assert!(sentence(simulate(&spec(3, 1), folder.path(), &watch)).contains("goes on there"));
    let nowhere = folder.path().join("nowhere");
    assert!(sentence(Dataset::load(&nowhere)).contains("nowhere holds no dataset"));
    let strange = tempfile::tempdir().unwrap();
    std::fs::write(strange.path().join("episode_00000.npz"), b"mine").unwrap();
    assert!(sentence(simulate(&spec(3, 1), strange.path(), &Watch::silent())).contains("another folder"));
    let left = files(strange.path());
    assert!(left.len() == 1 && left["episode_00000.npz"] == b"mine", "{:?}", left.keys());
    for impossible in [DatasetSpec { episodes: 0, ..spec(1, 1) }, DatasetSpec { steps: 2, ..spec(1, 1) }] {
        assert!(sentence(simulate(&impossible, &nowhere, &Watch::silent())).contains('`'));
        assert!(!nowhere.exists());
    }
}

#[test]
fn numpy_reads_the_files_and_we_read_numpy_s() {
    let folder = tempfile::tempdir().unwrap();
    let dataset = simulate(&spec(1, 3), folder.path(), &Watch::silent()).unwrap();
    let program = "
import sys, json
try:
    import numpy as np
except ImportError:
    sys.exit(77)
f = sys.argv[1] + '/episode_00000.npz'
x = np.load(f)['positions']
assert x.dtype == np.float32 and x.ndim == 3 and x.shape[0] == 7 and x.shape[2] == 3, (x.dtype, x.shape)
a = np.load(f)
assert a['tool_poses'].shape == (7, 2, 7) and a['tool_poses'].dtype == np.float64
assert a['theta'].shape == (3,) and float(a['interval']) > 0
m = json.load(open(sys.argv[1] + '/metadata.json'))
v = np.diff(x.astype(np.float64), axis=0)
assert np.allclose(v.mean((0, 1)), m['vel_mean'], atol=1e-12), (v.mean((0, 1)), m['vel_mean'])
s = v.std((0, 1))
assert np.allclose(np.where(s < 1e-7, 1, s), m['vel_std'], rtol=1e-9)
c = np.diff(v, axis=0).std((0, 1))
assert np.allclose(np.where(c < 1e-7, 1, c), m['acc_std'], rtol=1e-9)
np.savez(f, **{k: a[k] for k in a.files})
";
    let Ok(run) = std::process::Command::new("python3").args(["-c", program]).arg(folder.path()).output() else {
        return eprintln!("skipped: there is no python3");
    };
    if run.status.code() == Some(77) {
        return eprintln!("skipped: python3 has no numpy");
    }
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    assert_eq!(Dataset::load(folder.path()).unwrap().episodes, dataset.episodes);
}
