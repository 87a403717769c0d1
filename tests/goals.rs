//! Goals of shipped comparisons: each can be made, and letters lie where their dough lies.
use glam::DVec3;
use pliant::compare::{CompareSpec, Goal, Source};
use pliant::config;
use pliant::metric::{Chamfer, METRICS, Matching, Metric};
use pliant::world::World;
use std::path::{Path, PathBuf};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/compare")
}

fn load(name: &str, changes: &[&str]) -> CompareSpec {
    let words: Vec<String> = changes.iter().map(|word| (*word).to_owned()).collect();
    config::load(&folder().join(name).with_extension("toml"), &words).unwrap().spec
}

/// With the scene that is planned in.
fn planned(mut spec: CompareSpec) -> CompareSpec {
    spec.dataset.scene = spec.scene.take().unwrap_or(spec.dataset.scene);
    spec
}

fn make(spec: &CompareSpec, goal: &str, start: &World, seed: u64) -> anyhow::Result<Goal> {
    let source = Source { start, dataset: &spec.dataset, root: "".as_ref(), seed };
    spec.goal[goal].clone().build()?.make(&source)
}

#[test]
fn every_goal_of_every_comparison_can_be_made_with_as_many_points_as_particles() {
    let mut made = 0;
    for entry in std::fs::read_dir(folder()).unwrap() {
        let path = entry.unwrap().path();
        let spec: CompareSpec = match config::load(&path, &[]) {
            Ok(loaded) => loaded.spec,
            // What comparisons share leaves it to each of them what it is for.
            Err(error) => {
                assert!(error.to_string().contains("`goal`"), "{}: {error}", path.display());
                continue;
            }
        };
        if spec.start.is_some() || !spec.data.root.as_os_str().is_empty() {
            continue; // it needs recordings
        }
        let spec = planned(spec);
        let seed = spec.seeds[0];
        let start = World::new(&spec.dataset.scene, seed).unwrap();
        for name in spec.goal.keys() {
            let goal = make(&spec, name, &start, seed).unwrap_or_else(|error| panic!("{name}: {error:#}"));
            let before = start.particles().positions;
            assert_eq!(goal.points.len(), before.len(), "{name}");
            let away = Chamfer.evaluate(&before, &goal.points, Matching::Unmatched).unwrap();
            assert!(away > 5e-4, "{name}: the start is there already, {away} m");
            made += 1;
        }
    }
    assert!(made >= 26 + 8, "{made}");
}

#[test]
fn a_ring_and_a_letter_of_its_own_volume_can_be_asked_of_any_dough() {
    let spec = load("quickstart", &["goal=[ring,letter]"]);
    let start = World::new(&spec.dataset.scene, 5).unwrap();
    let ring = make(&spec, "ring", &start, 5).unwrap();
    let centre = pliant::tool::Workpiece::around(&start.particles()).centre;
    assert!(ring.points.iter().all(|p| (0.015..=0.045).contains(&(*p - centre).truncate().length())));
    let letter = make(&spec, "letter", &start, 5).unwrap();
    assert!(letter.points.iter().all(|p| (0.0..=0.02001).contains(&p.z)));
}

#[test]
fn a_word_has_a_letter_for_every_piece_where_that_lies() {
    let spec = planned(load("word", &[]));
    let start = World::new(&spec.dataset.scene, 0).unwrap();
    let goal = make(&spec, "word", &start, 0).unwrap();
    let (particles, pieces) = (start.particles().positions, start.pieces());
    for piece in 0..3 {
        let own: Vec<DVec3> = (0..pieces.len()).filter(|i| pieces[*i] == piece).map(|i| particles[i]).collect();
        let middle = own.iter().sum::<DVec3>() / own.len() as f64;
        let near = goal.points.iter().filter(|p| (p.x - middle.x).abs() < 0.08);
        assert_eq!(near.count(), own.len(), "piece {piece}");
    }
    let always = METRICS.iter().map(|metric| (metric.name(), *metric));
    assert!(goal.floors(always)["chamfer"].unwrap() > 0.0);
    let short = load("word", &["goal.word.text=TO"]);
    let refused = make(&short, "word", &start, 0).unwrap_err().to_string();
    assert!(refused.contains("2 letters") && refused.contains("3 pieces"), "{refused}");
}

#[test]
fn a_recipe_is_made_elsewhere_of_other_dough() {
    let spec = load("dumpling", &[]);
    let start = World::new(&spec.dataset.scene, 0).unwrap();
    let goal = make(&spec, "dumpling", &start, 0).unwrap();
    assert_eq!(goal.points, make(&spec, "dumpling", &start, 0).unwrap().points);
    assert_eq!(goal.matching, Matching::Unmatched);
    for change in [
        "goal.dumpling.material=dough",
        "goal.dumpling.seed=1001",
        "goal.dumpling.actions.1.action=[[0.5,0.5],[0.5,0.5],[0.1,0.1]]",
    ] {
        assert_ne!(make(&load("dumpling", &[change]), "dumpling", &start, 0).unwrap().points, goal.points, "{change}");
    }
    let strange = make(&load("dumpling", &["~dataset.tool.knife"]), "dumpling", &start, 0).unwrap_err().to_string();
    assert!(strange.contains("\"knife\"") && strange.contains("gripper_plane"), "{strange}");
}
