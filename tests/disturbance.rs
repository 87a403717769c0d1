//! What disturbances do to the world, whoever plans in it.
use glam::DVec3;
use pliant::compare::CompareSpec;
use pliant::compare::disturbance::{Disturbance, DisturbanceSpec, Patch};
use pliant::config;
use pliant::state::stream;
use pliant::world::World;

fn world(scene: &str) -> World {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/configs/compare/quickstart.toml");
    let changes = if scene == "quickstart" { vec![] } else { vec![format!("dataset.scene={scene}")] };
    World::new(&config::load::<CompareSpec>(path.as_ref(), &changes).unwrap().spec.dataset.scene, 1).unwrap()
}

fn shipped() -> [(&'static str, Box<dyn Disturbance>); 2] {
    ["push", "displace"].map(|stem| {
        let path = format!("{}/configs/disturbance/{stem}.toml", env!("CARGO_MANIFEST_DIR"));
        let spec: DisturbanceSpec = toml_edit::de::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
        (stem, spec.build().unwrap())
    })
}

fn moved(before: &[DVec3], after: &[DVec3]) -> f64 {
    before.iter().zip(after).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max)
}

#[test]
fn material_is_moved_further_than_a_plan_can_overlook_comes_to_rest_and_keeps_its_volume() {
    for scene in ["quickstart", "pile"] {
        for (name, disturbance) in shipped() {
            for seed in 0..3 {
                let mut world = world(scene);
                let (before, volume) = (world.all_positions(), world.volume());
                disturbance.disturb(&mut world, &mut stream(seed, &[1]));
                let after = world.all_positions();
                let most = moved(&before, &after);
                assert!((0.003..0.08).contains(&most), "{scene}, {name}, {seed}: {most} m");
                assert!((world.volume() / volume - 1.0).abs() < 0.01, "{scene}, {name}, {seed}");
                assert!(after.iter().all(|p| p.z > -1e-3), "{scene}, {name}, {seed}: below the table");
                world.wait(3);
                let later = moved(&after, &world.all_positions());
                assert!(later < 0.1 * most, "{scene}, {name}, {seed}: {later} m after it rested");
            }
        }
    }
}

#[test]
fn a_stream_disturbs_always_alike_and_leaves_off_at_the_same_number() {
    for (name, disturbance) in shipped() {
        let disturbed = |mut world: World, seed: u64| {
            let mut rng = stream(seed, &[1]);
            disturbance.disturb(&mut world, &mut rng);
            (world.snapshot(), rng.get_word_pos())
        };
        let (one, other) = (disturbed(world("quickstart"), 1), disturbed(world("quickstart"), 2));
        assert!(one == disturbed(world("quickstart"), 1) && one.0 != other.0, "{name}");
        assert_eq!(one.1, disturbed(world("pile"), 2).1, "{name}: another world takes other numbers");
    }
}

#[test]
fn a_patch_lies_on_the_material_and_fades_away_from_its_middle() {
    let world = world("quickstart");
    let all = world.all_positions();
    for seed in 0..20 {
        let patch = Patch::draw(&world, 0.01, [1.0, 2.0], &mut stream(seed, &[2]));
        let nearest = all.iter().map(|p| p.truncate().distance(patch.centre)).fold(f64::INFINITY, f64::min);
        assert!(nearest < 0.01 && (1.0..2.0).contains(&patch.amount));
        assert!((patch.direction.length() - 1.0).abs() < 1e-12 && patch.direction.z == 0.0);
        let at = |distance: f64| patch.weight((patch.centre + distance * glam::DVec2::X).extend(0.1));
        assert!(at(0.0) == 1.0 && (at(0.01) - (-0.5_f64).exp()).abs() < 1e-12 && at(0.05) < 1e-5);
    }
}
