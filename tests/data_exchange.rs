//! Recordings of others become datasets, and datasets become what others read.
use glam::DVec3;
use pliant::config;
use pliant::data::{
    Dataset, DatasetSpec, Episode, HELD_OUT, Info, LAYOUTS, Layout, RECORDINGS, check, export, import, simulate,
};
use pliant::model::{ModelSpec, WorldModel};
use pliant::train::{Split, evaluate};
use pliant::watch::Watch;
use std::path::Path;
use std::process::Command;

const BOXBATH: &str = "../shared/data/boxbath";

fn layout(name: &str) -> &'static dyn Layout {
    *LAYOUTS.iter().find(|layout| layout.name() == name).expect("a layout of that name")
}

/// Runs a Python program on some paths; `false`, with a message, where there is no Python or one of its packages is missing.
fn python(program: &str, paths: &[&Path]) -> bool {
    let program =
        format!("import sys\ntry:\n  import numpy as np, json\nexcept ImportError:\n  sys.exit(77)\n{program}");
    let Ok(run) = Command::new("python3").arg("-c").arg(program).args(paths).output() else {
        eprintln!("skipped: there is no python3");
        return false;
    };
    if run.status.code() == Some(77) {
        eprintln!("skipped: a package of Python is missing");
        return false;
    }
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    true
}

/// Four small recordings like those of the bath: a cube of 64 particles that slides along x, and 6 that fall from rest.
fn recordings(folder: &Path) -> bool {
    let program = "
t = np.arange(5) / 60
for name, speed in [('train_0', .1), ('train_1', .2), ('valid_0', .3), ('valid_1', .4)]:
    x = np.zeros((5, 70, 3), np.float32)
    i = np.arange(64)
    x[:, :64] = np.stack([i % 4, i // 4 % 4, i // 16], -1) * .05
    x[:, :64, 0] += (speed * t)[:, None]
    x[:, 64:, 0] = 1 + np.arange(6) * .05
    x[:, 64:, 1] = (.5 - 4.9 * t * t)[:, None]
    x[:, 64:, 2] = .2
    np.savez_compressed(f'{sys.argv[1]}/{name}.npz', positions=x)";
    python(program, &[folder])
}

#[test]
fn recordings_become_a_dataset_that_stands_upright_without_a_tool() {
    let (source, to) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    if !recordings(source.path()) {
        return;
    }
    let to = to.path().join("bath");
    let made = import(source.path(), RECORDINGS[0], &to).unwrap();
    let read = Dataset::load(&to).unwrap();
    assert_eq!((&read.episodes, &read.metadata), (&made.episodes, &made.metadata));
    assert_eq!(check(&to).unwrap().faults, [""; 0]);
    let info = Info::of(&to).unwrap();
    assert_eq!((info.train, info.held_out, info.steps), (2, 2, [4, 4]));
    assert!(info.to_text().contains("imported"), "{}", info.to_text());

    let (train, held_out) = read.split(HELD_OUT);
    for (speed, episode) in [0.1, 0.2, 0.3, 0.4].into_iter().zip(train.iter().chain(&held_out)) {
        let (cube, fluid): (Vec<usize>, Vec<usize>) = (0..70).partition(|i| episode.body[*i] == 1);
        assert_eq!((cube, fluid), ((0..64).collect(), (64..70).collect()));
        let last = &episode.states[4];
        // What was up is now along z, what was along z now points to −y, and velocities are backward differences.
        assert!((last.velocities[0] - DVec3::X * speed).length() < 1e-5, "{}", last.velocities[0]);
        assert!((last.velocities[65] + DVec3::Z * 9.8 * 3.5 / 60.0).length() < 1e-4, "{}", last.velocities[65]);
        assert!((episode.states[0].positions[64] - DVec3::new(1.0, -0.2, 0.5)).length() < 1e-6);
        assert_eq!(episode.states[0].velocities, [DVec3::ZERO; 70]);
        assert!((episode.interval - 1.0 / 60.0).abs() < 1e-15 && episode.start.is_empty());
    }

    // Models read it as any dataset: if nothing moves, the error is the motion.
    let still: ModelSpec = serde_json::from_value(serde_json::json!({ "kind": "still" })).unwrap();
    let split = Split::of(&read, HELD_OUT);
    let still: Box<dyn WorldModel> = still.build().unwrap();
    let evaluation = evaluate(still.as_ref(), &split.held_out, &split.tools).unwrap();
    assert!(evaluation.rollout > 0.0 && (evaluation.rollout - evaluation.still_rollout).abs() < 1e-12);

    let again = format!("{:#}", import(source.path(), RECORDINGS[0], &to).unwrap_err());
    assert!(again.contains("not empty"), "{again}");
    std::fs::write(source.path().join("train_9.npz"), "no recording").unwrap();
    let other = to.with_file_name("other");
    let bad = format!("{:#}", import(source.path(), RECORDINGS[0], &other).unwrap_err());
    assert!(bad.contains("train_9.npz") && !other.exists(), "{bad}");
    let empty = format!("{:#}", import(&to.with_file_name("no"), RECORDINGS[0], &other).unwrap_err());
    assert!(empty.contains("is missing"), "{empty}");
}

/// Mean squared error per coordinate over the rollout, averaged over episodes \[m²\]: `predict(t)` is where a particle that is at
/// `x` is `t` seconds later.
fn error(episodes: &[&Episode], predict: impl Fn(DVec3, f64) -> DVec3) -> f64 {
    let of = |episode: &&Episode| {
        // The first frame is before the first position solve; the published floors start from the one after it.
        let (start, later) = (&episode.states[1].positions, &episode.states[2..]);
        let squares = later.iter().zip(1..).flat_map(|(state, k)| {
            let t = f64::from(k) * episode.interval;
            start.iter().zip(&state.positions).map(|(x, y)| predict(*x, t).distance_squared(*y)).collect::<Vec<_>>()
        });
        squares.sum::<f64>() / (3 * start.len() * later.len()) as f64
    };
    episodes.iter().map(of).sum::<f64>() / episodes.len() as f64
}

#[test]
fn the_bath_has_its_published_floors() {
    if !Path::new(BOXBATH).exists() {
        return eprintln!("skipped: there is no {BOXBATH}");
    }
    let folder = tempfile::tempdir().unwrap();
    let dataset = import(BOXBATH.as_ref(), RECORDINGS[0], folder.path()).unwrap();
    let (train, held_out) = dataset.split(HELD_OUT);
    assert_eq!((train.len(), held_out.len()), (4, 2));
    let rounds_to =
        |value: f64, published: f64| assert!((value - published).abs() < 5e-4, "{value} is not {published}");
    rounds_to(error(&held_out, |x, _| x), 0.109);
    rounds_to(error(&held_out, |x, t| (x - 4.9 * t * t * DVec3::Z).with_z((x.z - 4.9 * t * t).max(0.0))), 0.072);
    for episode in &dataset.episodes {
        // The cube stays a cube: the distance between two of its corners, to what its solver leaves.
        let edge = |t: usize| episode.states[t].positions[0].distance(episode.states[t].positions[63]);
        assert!((edge(150) / edge(0) - 1.0).abs() < 0.02, "{} and {} m", edge(0), edge(150));
        assert!(episode.states[150].positions.iter().all(|p| p.z > -0.006), "the floor is at z = 0");
    }
}

#[test]
fn graph_network_simulators_read_the_export() {
    let (folder, out) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let words = ["steps=4", "scene.solver.steps=1", "episodes=12"].map(str::to_owned);
    let spec = config::load::<DatasetSpec>("configs/dataset/smoke.toml".as_ref(), &words).unwrap().spec;
    let dataset = simulate(&spec, folder.path(), &Watch::silent()).unwrap();
    let counts = export(folder.path(), layout("gns-npz"), out.path()).unwrap();
    // Of four episodes a tool one is held out; of three held out the first and third are in test.
    assert_eq!(counts, [("train", 9), ("valid", 1), ("test", 2)]);
    let surface: usize = dataset.tools["gripper_rod"].parts.iter().map(|p| p.surface.len()).sum();
    assert!(surface > 0);
    let program = "
source, out = sys.argv[1:3]
def entries(name):
    with np.load(f'{out}/{name}.npz', allow_pickle=True) as file:
        return [item for _, item in file.items()]
train = entries('train')
assert len(train) == 9 and len(entries('valid')) == 1 and len(entries('test')) == 2
for x, kinds in train:
    assert x.dtype == np.float32 and x.shape[0] == 5 and x.shape[2] == 3, (x.dtype, x.shape)
    assert kinds.shape == (x.shape[1],) and kinds.dtype == np.int64, (kinds.dtype, kinds.shape)
    assert (np.full(x.shape[1], kinds, dtype=int) == kinds).all()
    assert set(kinds) == {0, 3} and (kinds == 0).sum() == 144
    assert x.flags.writeable and x[0:2].transpose(1, 0, 2).shape == (x.shape[1], 2, 3)
a = np.load(f'{source}/episode_00000.npz')
x, kinds = train[0]
assert (x[:, kinds == 0] == a['positions']).all()
# The tool's particles move as its first part does: rigidly.
tool = x[:, kinds == 3]
d = lambda t: np.linalg.norm(tool[t, 0] - tool[t, 1])
assert abs(d(0) - d(4)) < 1e-6 and np.abs(tool[0] - tool[2]).max() > 1e-3
m, own = json.load(open(f'{out}/metadata.json')), json.load(open(f'{source}/metadata.json'))
for key in ['bounds', 'sequence_length', 'default_connectivity_radius', 'dim', 'dt', 'vel_mean', 'vel_std', 'acc_mean', 'acc_std']:
    assert key in m, key
assert m['sequence_length'] == 4 and m['dim'] == 3 and np.array(m['bounds']).shape == (3, 2) and m['bounds'][2][0] == 0
assert m['vel_std'] == own['vel_std']
import pickletools, zipfile, io
raw = zipfile.ZipFile(f'{out}/train.npz').read('simulation_trajectory_0.npy')
pickletools.dis(raw[10 + int.from_bytes(raw[8:10], 'little'):], io.StringIO())";
    python(program, &[folder.path(), out.path()]);
    let own = format!("{:#}", export(folder.path(), layout("gns-npz"), folder.path()).unwrap_err());
    assert!(own.contains("the dataset itself"), "{own}");
}

#[test]
#[cfg(feature = "hdf5")]
fn lagrangebench_reads_the_export() {
    let (source, to) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    if !recordings(source.path()) {
        return;
    }
    let (bath, out) = (to.path().join("bath"), to.path().join("out"));
    let made = import(source.path(), RECORDINGS[0], &bath).unwrap();
    export(&bath, layout("lagrangebench-h5"), &out).unwrap();
    let program = "
try:
    import h5py
except ImportError:
    sys.exit(77)
f = h5py.File(f'{sys.argv[2]}/train.h5', 'r')
assert list(f) == ['00000', '00001'] and f['00000/position'].dtype == np.float32
a = np.load(f'{sys.argv[1]}/episode_00001.npz')
assert (f['00001/position'][:] == a['positions']).all()
assert (f['00001/particle_type'][:] == np.r_[np.full(64, 3), np.zeros(6)]).all()
assert list(h5py.File(f'{sys.argv[2]}/valid.h5', 'r')) == list(h5py.File(f'{sys.argv[2]}/test.h5', 'r')) == ['00000']
m = json.load(open(f'{sys.argv[2]}/metadata.json'))
assert m['num_particles_max'] == 70 and m['sequence_length_train'] == 4 and 'spec' not in m";
    python(program, &[&bath, &out]);
    assert_eq!(made.episodes.len(), 4);
}

#[test]
fn bodies_become_types_that_are_not_the_kinematic_one() {
    let (source, to) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    if !recordings(source.path()) {
        return;
    }
    let (bath, out) = (to.path().join("bath"), to.path().join("out"));
    import(source.path(), RECORDINGS[0], &bath).unwrap();
    for layout in LAYOUTS {
        let free: Vec<i64> = (0..4).map(|body| layout.free(body)).collect();
        assert!(
            !free.contains(&layout.driven()) && free.windows(2).all(|w| w[0] < w[1]),
            "{}: {free:?}",
            layout.name()
        );
    }
    export(&bath, layout("gns-npz"), &out).unwrap();
    let program = "
with np.load(f'{sys.argv[1]}/test.npz', allow_pickle=True) as file:
    (x, kinds), = [item for _, item in file.items()]
assert x.shape == (5, 70, 3) and (kinds == np.r_[np.ones(64), np.zeros(6)]).all()";
    python(program, &[&out]);
}

#[test]
fn the_program_imports_and_exports_and_lists_the_formats_it_knows() {
    let folder = tempfile::tempdir().unwrap();
    let pliant = |words: &[&str]| {
        let output =
            Command::new(env!("CARGO_BIN_EXE_pliant")).current_dir(folder.path()).arg("data").args(words).output();
        let output = output.unwrap();
        let text = [&output.stdout[..], &output.stderr[..]].concat();
        (output.status.code(), String::from_utf8_lossy(&text).into_owned())
    };
    let (code, text) = pliant(&["import", "nowhere", "--to", "bath", "--format", "lunchbox"]);
    assert!(code == Some(2) && text.contains("there is boxbath"), "{text}");
    let (code, text) = pliant(&["export", "nowhere", "--to", "out", "--format", "gns-npz"]);
    assert!(code == Some(2) && text.contains("nowhere holds no dataset"), "{text}");
    if recordings(folder.path()) {
        assert_eq!(pliant(&["import", ".", "--to", "bath", "--format", "boxbath"]).1, "4 episodes in bath\n");
        let (code, text) = pliant(&["export", "bath", "--to", "out", "--format", "gns-npz"]);
        assert!(code == Some(0) && text.contains("2 in train, 1 in valid, 1 in test"), "{text}");
        assert!(folder.path().join("out/metadata.json").exists());
    }
}
