//! How a world begins.
use crate::bench::*;
use glam::DVec3;
use pliant::config;
use pliant::data::DatasetSpec;
use pliant::state::Control;
use pliant::world::{BlockSpec, DoughSpec, MaterialSpec, SceneSpec, SolverSpec, StartSpec, World};
use rayon::prelude::*;

#[test]
fn dough_fills_a_perceived_region_where_it_lies() {
    let (centre, radius) = (DVec3::new(0.1, -0.05, 0.0), 0.035);
    let ball = |p: DVec3| p.distance(centre) < radius;
    let bounds = (centre - DVec3::splat(radius).with_z(0.0), centre + DVec3::splat(radius));
    let world = World::around(&SceneSpec { particles: 60, ..spec() }, &ball, bounds).unwrap();
    let half_ball = 2.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
    assert!((world.volume() / half_ball - 1.0).abs() < 0.15, "{} of the ball's volume", world.volume() / half_ball);
    assert!((middle(&world.all_positions()) - centre).truncate().length() < 0.002);
    assert!(world.surface().len() < world.all_positions().len());
    let nothing = World::around(&spec(), &|_| false, bounds).err().unwrap().to_string();
    assert!(nothing.contains("spacing"), "{nothing}");
}

#[test]
fn model_particles_spread_over_the_dough() {
    let world = World::new(&spec(), 1).unwrap();
    let (all, chosen) = (world.all_positions(), world.particles().positions);
    assert_eq!(chosen.len(), 120);
    let nearest = |p: &DVec3| chosen.iter().map(|q| q.distance(*p)).fold(f64::INFINITY, f64::min);
    let gap = all.iter().map(nearest).fold(0.0, f64::max);
    assert!(gap < 0.0115, "a particle is {gap} m from the next chosen one");
}

#[test]
fn impossible_scenes_name_their_key() {
    let material = |change: fn(&mut DoughSpec)| {
        let mut material = dough();
        change(&mut material);
        SceneSpec { material: MaterialSpec::Dough(material), ..spec() }
    };
    let wide = StartSpec::Block(BlockSpec { x: [0.06, 0.01], y: [0.06; 2], z: [0.03; 2], turn: [0.0; 2] });
    for (spec, key) in [
        (material(|m| m.density = -1.0), "material.density"),
        (material(|m| m.poisson_ratio = 0.5), "material.poisson_ratio"),
        (material(|m| m.friction = f64::NAN), "material.friction"),
        (SceneSpec { spacing: 0.0, ..spec() }, "scene.spacing"),
        (SceneSpec { particles: 10_000, ..spec() }, "scene.particles"),
        (SceneSpec { solver: SolverSpec { sweeps: 0, ..spec().solver }, ..spec() }, "scene.solver.sweeps"),
        (SceneSpec { start: wide, ..spec() }, "start.x"),
    ] {
        let error = World::new(&spec, 0).err().expect(key).to_string();
        assert!(error.contains(key), "{error}");
    }
}

#[test]
fn the_shipped_scene_builds_at_both_ends_of_its_ranges() {
    let read = |path: &str| std::fs::read_to_string(path).unwrap().parse::<toml_edit::DocumentMut>().unwrap();
    let mut scene = read("configs/scene/dough.toml");
    scene["material"] = toml_edit::Item::Table(read("configs/material/dough.toml").as_table().clone());
    let shipped: SceneSpec = toml_edit::de::from_document(scene).unwrap();
    let StartSpec::Block(ranges) = &shipped.start else { panic!("the shipped start is a block") };
    for end in [0, 1] {
        let of = |range: [f64; 2]| [range[end]; 2];
        let block = BlockSpec { x: of(ranges.x), y: of(ranges.y), z: of(ranges.z), turn: of(ranges.turn) };
        let world = World::new(&SceneSpec { start: StartSpec::Block(block), ..shipped.clone() }, 0).unwrap();
        assert_eq!(world.particles().len(), shipped.particles);
    }
    assert_eq!(SceneSpec { start: spec().start, ..shipped }, spec(), "the tests measure what is shipped");
}

#[test]
fn every_shipped_material_makes_a_scene_that_stays_on_the_table() {
    let files = std::fs::read_dir("configs/material").unwrap();
    let mut stems: Vec<_> =
        files.map(|f| f.unwrap().path().file_stem().unwrap().to_str().unwrap().to_owned()).collect();
    stems.sort();
    stems.par_iter().for_each(|stem| {
        let change = format!("scene.material={stem}");
        let spec =
            config::load::<DatasetSpec>("configs/dataset/pile_push.toml".as_ref(), &[change]).unwrap().spec.scene;
        let mut world = World::new(&spec, 5).unwrap();
        (0..5).for_each(|_| world.step(&Control::default()));
        for p in world.all_positions() {
            assert!(p.is_finite() && p.z > -5e-4 && p.length() < 2.0, "{stem}: a particle at {p}");
        }
    });
}
