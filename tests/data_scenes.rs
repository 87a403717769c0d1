//! The datasets that are shipped: each records episodes of the scene it names.
use pliant::config;
use pliant::data::{Dataset, DatasetSpec, record, simulate};
use pliant::watch::Watch;
use pliant::world::MaterialSpec;
use rayon::prelude::*;

fn load(stem: &str, changes: &[&str]) -> DatasetSpec {
    let path = format!("configs/dataset/{stem}.toml");
    let changes: Vec<String> = changes.iter().map(|change| (*change).to_owned()).collect();
    config::load::<DatasetSpec>(path.as_ref(), &changes).unwrap().spec
}

#[test]
fn every_shipped_dataset_records_an_episode_that_moves() {
    let files = std::fs::read_dir("configs/dataset").unwrap();
    let mut stems: Vec<_> =
        files.map(|f| f.unwrap().path().file_stem().unwrap().to_str().unwrap().to_owned()).collect();
    stems.sort();
    assert!(stems.len() >= 10, "{stems:?}");
    stems.par_iter().filter(|stem| *stem != "robocook").for_each(|stem| {
        let episode = record(&load(stem, &["seed=3"]), 1).unwrap();
        let (first, last) = (&episode.states[0], episode.states.last().unwrap());
        let farthest = first.positions.iter().zip(&last.positions).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
        assert!(farthest < 1.0, "{stem}: a particle went {farthest} m");
        // A pusher may pass beside the few grains of a pile.
        assert!(farthest > 1e-3 || stem == "pile_push", "{stem}: nothing moved further than {farthest} m");
        assert!(last.positions.iter().all(|p| p.z > -2e-3), "{stem}: a particle is below the table");
    });
}

#[test]
fn the_cube_of_the_bath_is_a_body_of_its_own_and_stays_rigid() {
    let episode = record(&load("box_bath", &[]), 0).unwrap();
    let first = episode.body.iter().position(|body| *body == 1).unwrap();
    assert!(first > 100 && episode.body[first..].iter().all(|body| *body == 1), "bodies in two runs");
    let (start, end) = (&episode.states[0].positions[first..], &episode.states.last().unwrap().positions[first..]);
    for (a, b) in start.iter().zip(end) {
        // Positions are kept as float32.
        assert!((a.distance(start[0]) - b.distance(end[0])).abs() < 1e-6, "the cube is bent");
    }
    let middle = |points: &[glam::DVec3]| points.iter().sum::<glam::DVec3>() / points.len() as f64;
    assert!(middle(end).z < middle(start).z - 0.02, "the cube did not fall");
    assert!(middle(end).z > 0.025, "wood does not sink to the table: {}", middle(end));
}

#[test]
fn constants_are_drawn_for_each_episode_and_written_down() {
    let folder = tempfile::tempdir().unwrap();
    let spec = load("rice_grip", &["episodes=4", "scene.particles=20", "steps=3"]);
    let made = simulate(&spec, folder.path(), &Watch::silent()).unwrap();
    let Dataset { metadata, episodes, tools } = Dataset::load(folder.path()).unwrap();
    assert_eq!(episodes, made.episodes);
    for (episode, entry) in episodes.iter().zip(&metadata.episodes) {
        let told = episode.scene(1, &tools[&episode.tool]).constants;
        assert_eq!((&*told, told.len()), (&entry.constants, 2), "models are told what was drawn");
    }
    let planned = spec.constants();
    let MaterialSpec::Dough(material) = &spec.scene.material else { panic!("rice_grip grips dough") };
    assert_eq!(
        planned["material.young_modulus"], material.young_modulus,
        "and of the world that is planned in, its own"
    );
    let drawn: Vec<f64> = metadata.episodes.iter().map(|e| e.constants["material.young_modulus"]).collect();
    assert!(drawn.iter().all(|e| (3e3..=1.2e4).contains(e)), "{drawn:?}");
    assert!(drawn.windows(2).all(|pair| pair[0] != pair[1]), "{drawn:?}");

    // The dough is as stiff as was drawn: alone with that number, the episode is the same.
    let alone = |k: usize| {
        let constants = &metadata.episodes[k].constants;
        let set =
            |name: &str| format!("vary.\"material.{name}\"=[{0:?},{0:?}]", constants[&format!("material.{name}")]);
        let [stiff, firm] = ["young_modulus", "yield_strain"].map(set);
        load("rice_grip", &["scene.particles=20", "steps=3", &stiff, &firm])
    };
    let again = record(&alone(2), 2).unwrap();
    assert_eq!(again, record(&spec, 2).unwrap());
    assert_ne!(again.states, record(&alone(1), 2).unwrap().states);
}

#[test]
fn a_constant_that_the_scene_has_not_is_refused_with_its_path() {
    let folder = tempfile::tempdir().unwrap();
    for (change, words) in [
        ("+vary.\"material.stiffness\"=[1.0,2.0]", ["scene.material.stiffness", "no number"]),
        ("+vary.\"material.friction\"=[2.0,1.0]", ["scene.material.friction", "[2, 1]"]),
    ] {
        let error = simulate(&load("rice_grip", &[change]), folder.path(), &Watch::silent()).unwrap_err();
        assert!(words.iter().all(|word| error.to_string().contains(word)), "{error}");
    }
}
