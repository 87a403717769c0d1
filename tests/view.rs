//! The page that plays an episode: it stands alone, carries the recorded numbers, and nothing in a file can become markup; the same
//! numbers reach Rerun's recording.
use base64::Engine;
use base64::engine::general_purpose::STANDARD_NO_PAD;
use glam::{DQuat, DVec3, Vec3};
use pliant::config;
use pliant::data::{DatasetSpec, Episode};
use pliant::graph::{GraphSpec, Nodes, near_kinds};
use pliant::state::{Control, Particles, Pose, Wall};
use pliant::view::{Playback, Prediction};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A block of particles that sinks under a tool of `parts` parts; nothing physical.
fn made_up(frames: usize, count: usize, parts: usize) -> Episode {
    let position = |t: usize, i: usize| {
        let (x, y, z) = (i % 8, i / 8 % 8, i / 64);
        let wobble = (i as f32 * 0.37).sin() * 1e-3;
        Vec3::new(0.008 * x as f32 + wobble, 0.008 * y as f32, 0.004 + (0.008 - 1e-5 * t as f32) * z as f32).as_dvec3()
    };
    let pose = |t: usize| Pose {
        translation: DVec3::new(0.03, 0.03, 0.08 - 0.002 * (t % 16) as f64),
        rotation: DQuat::from_rotation_z(0.3 * t as f64),
    };
    let state = |t| Particles::at_rest((0..count).map(|i| position(t, i)).collect());
    Episode {
        tool: String::new(),
        theta: vec![0.01],
        interval: 0.1,
        start: vec![pose(0); parts],
        controls: (1..frames).map(|t| Control { poses: vec![pose(t); parts] }).collect(),
        states: (0..frames).map(state).collect(),
        body: vec![0; count].into(),
        walls: [Wall { normal: DVec3::X, offset: -0.01 }].into(),
        constants: Default::default(),
    }
}

/// A folder with one episode and the spec of its dataset, whose only tool is called `tool`.
fn dataset(tool: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut spec = config::load::<DatasetSpec>(&root.join("configs/dataset/smoke.toml"), &[]).unwrap().spec;
    let press = spec.tool["press_square"].clone();
    spec.tool = [(tool.to_owned(), press)].into_iter().collect();
    std::fs::write(folder.path().join("dataset.toml"), toml_edit::ser::to_string(&spec).unwrap()).unwrap();
    let path = folder.path().join("episode_00002.npz");
    made_up(16, 300, 1).write(&path).unwrap();
    (folder, path)
}

fn page(recording: &Playback, prediction: Option<&Prediction>) -> String {
    std::fs::read_to_string(recording.write_page(prediction, None).unwrap()).unwrap()
}

/// What the page's scripts are told.
fn data(page: &str) -> Value {
    let (_, rest) = page.split_once("id=\"data\">").expect("the element with the data");
    serde_json::from_str(rest.split_once("</script>").expect("its end").0).expect("JSON")
}

fn singles(text: &Value) -> Vec<f32> {
    let bytes = STANDARD_NO_PAD.decode(text.as_str().unwrap()).unwrap();
    bytes.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect()
}

fn doubles(text: &Value) -> Vec<f64> {
    let bytes = STANDARD_NO_PAD.decode(text.as_str().unwrap()).unwrap();
    bytes.as_chunks().0.iter().map(|b| f64::from_le_bytes(*b)).collect()
}

fn rows(states: &[Particles]) -> Vec<f32> {
    states.iter().flat_map(|x| &x.positions).flat_map(|p| p.as_vec3().to_array()).collect()
}

#[test]
fn the_page_loads_nothing_and_stays_small() {
    let (_folder, path) = dataset("press_square");
    let text = page(&Playback::open(&path).unwrap(), None);
    for loaded in ["http://", "https://", "src=", "url(", "import ", "<link"] {
        assert!(!text.contains(loaded), "{loaded}");
    }
    assert!(text.len() < 500_000, "16 frames of 300 particles take {} bytes", text.len());
    assert!(!text.contains("{{"), "a hole was left");
    let long = path.with_file_name("long.npz");
    made_up(151, 1024, 1).write(&long).unwrap();
    let size = page(&Playback::open(&long).unwrap(), None).len();
    assert!(size < 4_000_000, "151 frames of 1024 particles take {size} bytes");
}

#[test]
fn the_embedded_numbers_are_the_recorded_ones() {
    let (_folder, path) = dataset("press_square");
    let recording = Playback::open(&path).unwrap();
    let (episode, shape) = (&recording.episode, recording.shape.as_ref().unwrap());
    let told = data(&page(&recording, None));
    assert_eq!(singles(&told["positions"]), rows(&episode.states));
    let poses = (0..16).flat_map(|t| episode.poses(t));
    let poses: Vec<f64> =
        poses.flat_map(|p| p.translation.to_array().into_iter().chain(p.rotation.to_array())).collect();
    assert_eq!(doubles(&told["tool"]["poses"]), poses);
    let samples: Vec<f64> = shape.parts[0].surface.iter().flat_map(|p| p.position.to_array()).collect();
    assert_eq!(doubles(&told["tool"]["parts"][0]["samples"]), samples);
    assert_eq!([&told["frames"], &told["particles"], &told["interval"]], [&json!(16), &json!(300), &json!(0.1)]);
    assert_eq!(told["bodies"], json!([{ "material": "dough", "particles": 300 }]));
    assert_eq!(told["tool"]["name"], "press_square");
}

#[test]
fn the_counts_to_compare_with_are_those_of_the_radius_policy() {
    let (_folder, path) = dataset("press_square");
    let recording = Playback::open(&path).unwrap();
    let told = data(&page(&recording, None));
    let names: Vec<&str> = near_kinds().map(|kind| kind.name()).collect();
    assert_eq!(told["graph"]["kinds"], json!(names));
    let counts = told["graph"]["counts"].as_array().unwrap();
    assert!(counts.len() >= 4);
    let mut total = vec![0; names.len()];
    for count in counts {
        let policy: GraphSpec =
            serde_json::from_value(json!({ "kind": "radius", "radius": count["radius"], "edges": names })).unwrap();
        let t = count["frame"].as_u64().unwrap() as usize;
        let (episode, shape) = (&recording.episode, recording.shape.as_ref().unwrap());
        let (dt, poses) = (episode.interval, episode.poses(t));
        let nodes = Nodes::gather(&episode.states[t], &Default::default(), &episode.walls, shape, poses, poses, dt);
        let graph = policy.build().unwrap().connect(nodes);
        let edges: Vec<usize> = graph.edges[..names.len()].iter().map(|set| set.len()).collect();
        assert_eq!(count["edges"], json!(edges), "frame {t}");
        total.iter_mut().zip(edges).for_each(|(sum, n)| *sum += n);
    }
    assert!(total.iter().all(|n| *n > 0), "a kind was never drawn: {total:?}");
}

#[test]
fn a_name_is_never_markup() {
    let hostile = "</script><script>alert(1)</script><img onerror=alert(2)>{{data}}";
    let (_folder, path) = dataset(hostile);
    let path = {
        let odd = path.with_file_name("episode_00002.<b>{{script}}.npz");
        std::fs::rename(&path, &odd).unwrap();
        odd
    };
    let mut recording = Playback::open(&path).unwrap();
    recording.episode.tool = hostile.to_owned();
    recording.pieces = vec!["<!--<script>".to_owned()];
    let text =
        page(&recording, Some(&Prediction { model: hostile.to_owned(), rollout: recording.episode.states.clone() }));
    let (plain, plain_path) = dataset("press_square");
    let plain_page = page(&Playback::open(&plain_path).unwrap(), None);
    drop(plain);
    for mark in ["<script", "</script", "<b>", "<img", "<!--"] {
        assert_eq!(text.matches(mark).count(), plain_page.matches(mark).count(), "{mark}");
    }
    let told = data(&text);
    assert_eq!([&told["tool"]["name"], &told["prediction"]["model"]], [hostile, hostile]);
    assert_eq!(told["title"], "episode_00002.<b>{{script}}.npz");
}

#[test]
fn a_file_outside_a_dataset_plays_without_its_tools_shape_and_a_tool_of_no_parts_is_none() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("alone.npz");
    made_up(4, 20, 2).write(&path).unwrap();
    let recording = Playback::open(&path).unwrap();
    assert!(recording.shape.is_none() && recording.pieces.is_empty());
    let told = data(&page(&recording, None));
    assert_eq!(told["tool"]["parts"].as_array().unwrap().len(), 2);
    assert_eq!(told["tool"]["parts"][0]["vertices"], "");
    assert_eq!(doubles(&told["tool"]["poses"]).len(), 4 * 2 * 7);
    assert_eq!(told["graph"]["counts"][0]["edges"][1], 0, "nothing is known of the tool's surface");

    let nothing = Playback { episode: made_up(4, 1, 0), ..recording };
    let told = data(&page(&nothing, None));
    assert_eq!(told["tool"]["parts"], json!([]));
    assert_eq!(told["graph"]["counts"][0]["edges"][0], 0);
}

#[test]
fn a_prediction_lies_over_what_happened_with_its_error_in_every_frame() {
    let (_folder, path) = dataset("press_square");
    let recording = Playback::open(&path).unwrap();
    let mut rollout = recording.episode.states.clone();
    for (t, state) in rollout.iter_mut().enumerate() {
        state.positions.iter_mut().for_each(|p| *p += 0.001 * t as f64 * DVec3::new(0.6, 0.0, 0.8));
    }
    rollout[15].positions[3].x = f64::NAN;
    let prediction = Prediction { model: "learned".into(), rollout };
    let told = data(&page(&recording, Some(&prediction)));
    let shown = singles(&told["prediction"]["positions"]);
    assert_eq!(shown[..100], rows(&prediction.rollout)[..100]);
    let rmse = told["prediction"]["rmse"].as_array().unwrap();
    for (t, error) in rmse[..15].iter().enumerate() {
        assert!((error.as_f64().unwrap() - 0.001 * t as f64).abs() < 1e-9, "frame {t}: {error}");
    }
    assert!(rmse[15].is_null(), "what is no number has no finite error");
}

/// What a Rerun recording holds of points or vectors at `entity`: (frame, rows), the static ones left out.
#[cfg(feature = "rerun")]
fn logged(file: &Path, entity: &str, what: rerun::ComponentDescriptor) -> Vec<(i64, Vec<f32>)> {
    use rerun::{external::re_log_encoding::DecoderApp, log::Chunk, log::LogMsg};
    let reader = std::io::BufReader::new(std::fs::File::open(file).unwrap());
    let mut found = Vec::new();
    for message in DecoderApp::decode_lazy(reader) {
        let LogMsg::ArrowMsg(_, message) = message.unwrap() else { continue };
        let chunk = Chunk::from_arrow_msg(&message).unwrap();
        if *chunk.entity_path() == rerun::EntityPath::from(entity) && !chunk.is_static() {
            let frames = chunk.iter_component_indices("frame".into(), what.component).map(|(t, _)| t.as_i64());
            let rows = chunk.iter_slices::<[f32; 3]>(what.component).map(|rows| rows.as_flattened().to_vec());
            found.extend(frames.zip(rows));
        }
    }
    found.sort_by_key(|(frame, _)| *frame);
    found
}

#[cfg(feature = "rerun")]
#[test]
fn the_recording_for_rerun_holds_the_recorded_numbers_in_their_frames() {
    use rerun::{Arrows3D, Points3D, Transform3D};
    let (_folder, path) = dataset("press_square");
    let (recording, file) = (Playback::open(&path).unwrap(), path.with_extension("rrd"));
    let states = &recording.episode.states;
    let prediction = Prediction { model: "still".into(), rollout: vec![states[0].clone(); 16] };
    recording.write_rrd(Some(&prediction), &file).unwrap();
    let frames = |of: &[Particles]| (0..).zip(of).map(|(t, x)| (t, rows(std::slice::from_ref(x)))).collect::<Vec<_>>();
    assert_eq!(logged(&file, "particles", Points3D::descriptor_positions()), frames(states));
    assert_eq!(logged(&file, "predicted", Points3D::descriptor_positions()), frames(&prediction.rollout));
    let tool: Vec<_> =
        (0..16).map(|t| recording.episode.poses(t)[0].translation.as_vec3().to_array().to_vec()).collect();
    assert_eq!(logged(&file, "tool/0", Transform3D::descriptor_translation()), (0..).zip(tool).collect::<Vec<_>>());
    let forces = logged(&file, "forces", Arrows3D::descriptor_vectors());
    let sizes: Vec<usize> = forces.iter().map(|(_, rows)| rows.len()).collect();
    assert_eq!(sizes, [vec![0], vec![900; 14], vec![0]].concat());
    assert!(forces.iter().flat_map(|(_, rows)| rows).all(|f| f.abs() < 1e-6), "they sink at a constant speed");
}

fn pliant(folder: &Path, words: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_pliant")).current_dir(folder).args(words).output().expect("the program starts")
}

fn complaint(output: &Output) -> String {
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(!text.contains("panicked") && output.stdout.is_empty(), "{text}");
    text
}

#[test]
fn the_command_writes_beside_the_episode_and_bad_input_overwrites_nothing() {
    let (folder, path) = dataset("press_square");
    let here = folder.path();
    let output = pliant(here, &["view", "episode_00002.npz"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(String::from_utf8_lossy(&output.stdout), "episode_00002.html\n");
    assert!(pliant(here, &["view", "episode_00002.npz", "--to", "pages/a.html"]).status.success());
    let before = std::fs::read_to_string(here.join("episode_00002.html")).unwrap();
    assert_eq!(std::fs::read_to_string(here.join("pages/a.html")).unwrap(), before);

    let listed = complaint(&pliant(here, &["view", "."]));
    assert!(listed.contains("folder") && listed.contains("episode_00002.npz"), "{listed}");
    let missing = complaint(&pliant(here, &["view", "episode_00009.npz"]));
    assert!(missing.contains("episode_00009.npz is missing"), "{missing}");
    let itself = complaint(&pliant(here, &["view", "episode_00002.npz", "--to", "./episode_00002.npz"]));
    assert!(itself.contains("is the episode itself"), "{itself}");
    assert!(complaint(&pliant(here, &["view", "episode_00002.npz", "--model", "learned"])).contains("--compare"));
    let rrd = pliant(here, &["view", "episode_00002.npz", "--rrd", "a.rrd"]);
    if cfg!(feature = "rerun") {
        assert!(rrd.status.success() && std::fs::read(here.join("a.rrd")).unwrap().starts_with(b"RRF"));
        let itself = complaint(&pliant(here, &["view", "episode_00002.npz", "--rrd", "episode_00002.npz"]));
        assert!(itself.contains("is the episode itself"), "{itself}");
    } else {
        assert!(complaint(&rrd).contains("--features rerun") && !here.join("a.rrd").exists());
    }
    let whole = std::fs::read(&path).unwrap();
    for keep in [0, 40, whole.len() / 2, whole.len() - 1] {
        std::fs::write(&path, &whole[..keep]).unwrap();
        let truncated = complaint(&pliant(here, &["view", "episode_00002.npz"]));
        assert!(truncated.contains("episode_00002.npz") && truncated.contains("make it again"), "{truncated}");
    }
    std::fs::write(&path, "not an archive").unwrap();
    assert!(complaint(&pliant(here, &["view", "episode_00002.npz"])).contains("not a .npz"));
    assert_eq!(std::fs::read_to_string(here.join("episode_00002.html")).unwrap(), before, "the page was overwritten");

    made_up(16, 300, 2).write(&path).unwrap();
    let other = complaint(&pliant(here, &["view", "episode_00002.npz"]));
    assert!(other.contains("2 tool parts") && other.contains("dataset.toml"), "{other}");
    std::fs::write(here.join("dataset.toml"), "episodes = ").unwrap();
    made_up(16, 300, 1).write(&path).unwrap();
    let damaged = complaint(&pliant(here, &["view", "episode_00002.npz"]));
    assert!(damaged.contains("dataset.toml is not a dataset's spec"), "{damaged}");
}
