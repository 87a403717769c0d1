//! What disturbances do to the world, and that they do it alike whoever plans.
use glam::DVec3;
use pliant::compare::disturbance::{DisplaceSpec, DisturbanceSpec, PushSpec};
use pliant::compare::CompareSpec;
use pliant::config;
use pliant::state::{Particles, stream};
use pliant::world::World;

fn world(seed: u64) -> World {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/configs/compare/quickstart.toml");
    let spec = config::load::<CompareSpec>(path.as_ref(), &[]).unwrap().spec;
    World::new(&spec.dataset.scene, seed).unwrap()
}

fn kinds() -> [(&'static str, DisturbanceSpec); 2] {
    ["push", "displace"].map(|stem| {
        let path = format!("{}/configs/disturbance/{stem}.toml", env!("CARGO_MANIFEST_DIR"));
        (stem, toml_edit::de::from_str(&std::fs::read_to_string(path).unwrap()).unwrap())
    })
}

fn moved(before: &[DVec3], after: &[DVec3]) -> Vec<f64> {
    before.iter().zip(after).map(|(a, b)| a.distance(*b)).collect()
}

#[test]
fn a_part_of_the_dough_is_moved_and_stays_moved_at_equal_volume() {
    for (name, spec) in kinds() {
        let disturbance = spec.build().unwrap();
        for seed in 0..3 {
            let mut world = world(seed);
            let (before, volume) = (world.all_positions(), world.volume());
            disturbance.disturb(&mut world, &mut stream(seed, &[1]));
            let after = world.all_positions();
            let shifts = moved(&before, &after);
            let (most, mean) = (shifts.iter().copied().fold(0.0, f64::max), shifts.iter().sum::<f64>() / shifts.len() as f64);
            println!("{name} {seed}: most {most} mean {mean} volume {}", world.volume() / volume);
            world.wait(5);
            let later = moved(&after, &world.all_positions());
            println!("   later {}", later.iter().copied().fold(0.0, f64::max));
        }
    }
}
