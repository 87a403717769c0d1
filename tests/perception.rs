//! Perception: ground truth, a made scene with known volume, and the clouds of a real robot.
use glam::{DVec2, DVec3};
use pliant::perception::{Cloud, CloudSpec, Observation, Perception, PerceptionSpec};
use pliant::shape::{Shape, read_points};
use pliant::state::Particles;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::path::PathBuf;

fn spec(name: &str) -> PerceptionSpec {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(format!("configs/perception/{name}.toml"));
    toml_edit::de::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn cloud() -> Cloud {
    let PerceptionSpec::Cloud(spec) = spec("cloud") else { panic!("cloud.toml is not of kind cloud") };
    CloudSpec::build(spec).unwrap()
}

/// Outside of a block 60 × 40 × 20 mm on a tilted table at 0.1 m, with noise; the table only when `table` > 0.
fn block(table: usize, strays: usize) -> Vec<DVec3> {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut points: Vec<DVec3> = Vec::new();
    let (half, height) = (DVec2::new(0.03, 0.02), 0.02);
    for _ in 0..1000 {
        let at = half * DVec2::new(rng.random_range(-1.0..1.0), rng.random_range(-1.0..1.0));
        points.push(at.extend(height));
        let z = rng.random_range(0.0..height);
        points.push(
            if rng.random() { at.with_x(half.x.copysign(at.x)) } else { at.with_y(half.y.copysign(at.y)) }.extend(z),
        );
    }
    for _ in 0..table {
        let at = 0.08 * DVec2::new(rng.random_range(-1.0..1.0), rng.random_range(-1.0..1.0));
        if at.abs().cmpgt(half).any() {
            points.push(at.extend(0.0));
        }
    }
    // Something else on the table, as dense as the block.
    let plate = |i: usize| DVec3::new(0.05 + 1e-3 * (i % 20) as f64, 0.05 + 1e-3 * (i / 20) as f64, 0.01);
    points.extend((0..33 * strays).map(plate));
    points.extend((0..strays).map(|i| DVec3::new(0.06, 0.005 * i as f64 - 0.05, 0.03 + 0.001 * i as f64)));
    let noise = |p: DVec3, rng: &mut ChaCha8Rng| p + 3e-4 * DVec3::splat(rng.random_range(-1.0..1.0));
    points.iter().map(|p| noise(*p, &mut rng) + DVec3::Z * (0.1 + 0.01 * p.x - 0.02 * p.y)).collect()
}

#[test]
fn a_block_is_found_on_its_table_and_filled() {
    for (table, strays) in [(2000, 0), (2000, 12), (0, 0)] {
        let observation = Observation::Cloud(block(table, strays));
        let region = cloud().region(&observation).unwrap();
        assert!((region.volume() / 4.8e-5 - 1.0).abs() < 0.15, "{table} {strays}: {} m³", region.volume());
        let (low, high) = region.bounds();
        assert!(low.distance(DVec3::new(-0.03, -0.02, 0.0)) < 0.005, "{table} {strays}: {low}");
        assert!(high.distance(DVec3::new(0.03, 0.02, 0.02)) < 0.005, "{table} {strays}: {high}");
        let perceive = || cloud().perceive(&observation, 300, &mut ChaCha8Rng::seed_from_u64(6)).unwrap();
        let particles = perceive();
        assert_eq!((particles.len(), &particles), (300, &perceive()));
        assert!(particles.positions.iter().all(|p| region.contains(*p)));
        assert!(particles.velocities.iter().all(|v| *v == DVec3::ZERO));
    }
}

#[test]
fn truth_passes_through_and_misuse_is_a_sentence() {
    let truth = spec("truth").build().unwrap();
    let particles = Particles::at_rest(vec![DVec3::ONE; 5]);
    let rng = &mut ChaCha8Rng::seed_from_u64(7);
    let seen = Observation::Particles(particles.clone());
    assert_eq!(truth.perceive(&seen, 5, rng).unwrap(), particles);
    assert!(truth.perceive(&seen, 6, rng).unwrap_err().to_string().contains('5'));
    assert!(truth.perceive(&Observation::Cloud(vec![]), 5, rng).is_err());
    assert!(cloud().region(&seen).is_err());
    for hopeless in [vec![], vec![DVec3::ZERO; 10], vec![DVec3::NAN; 10]] {
        assert!(cloud().region(&Observation::Cloud(hopeless)).is_err());
    }
}

/// Sum of the two mean distances to the nearest point of the other cloud \[m\].
fn chamfer(a: &[DVec3], b: &[DVec3]) -> f64 {
    let nearest =
        |p: &DVec3, to: &[DVec3]| to.iter().map(|q| p.distance_squared(*q)).fold(f64::INFINITY, f64::min).sqrt();
    let mean = |from: &[DVec3], to: &[DVec3]| from.iter().map(|p| nearest(p, to)).sum::<f64>() / from.len() as f64;
    mean(a, b) + mean(b, a)
}

#[test]
fn real_dough_is_perceived_as_its_makers_perceived_it() {
    let here = || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/data/robocook");
    let data = std::env::var_os("PLIANT_DATA").map_or_else(here, PathBuf::from).join("targets");
    if !data.is_dir() {
        println!("skipped: {} is not there", data.display());
        return;
    }
    let stages = ["dumpling_0_start", "dumpling_2_gripper", "dumpling_3_press", "dumpling_4_roller", "letter_B_start"];
    for stage in stages {
        let observation = Observation::Cloud(read_points(&data.join(format!("{stage}_raw.ply"))).unwrap());
        let region = cloud().region(&observation).unwrap();
        let ours = region.points(1000, &mut ChaCha8Rng::seed_from_u64(8));
        let mut theirs = read_points(&data.join(format!("{stage}_dense.npy"))).unwrap();
        // Theirs are in the robot's frame, whose table lies about 3 mm high.
        theirs.iter_mut().for_each(|p| p.z -= 0.003);
        let theirs: Vec<_> = theirs.into_iter().step_by(4).collect();
        let distance = chamfer(&ours, &theirs);
        // What two samplings of the very same volume differ by.
        let floor = chamfer(&ours, &region.points(theirs.len(), &mut ChaCha8Rng::seed_from_u64(9)));
        let millimetres = |x: f64| format!("{:.2} mm", x * 1e3);
        let (distance, floor) = (millimetres(distance), (millimetres(floor), distance - floor));
        println!("{stage}: {:.1} ml, Chamfer to the makers' {distance}, floor {}", region.volume() * 1e6, floor.0);
        assert!(floor.1 < 0.002, "{stage}: {distance} against a floor of {}", floor.0);
    }
    // The same lump before and after the press.
    let volume = |stage: &str| {
        let cloud_points = read_points(&data.join(format!("{stage}_raw.ply"))).unwrap();
        cloud().region(&Observation::Cloud(cloud_points)).unwrap().volume()
    };
    let (before, after) = (volume("dumpling_2_gripper"), volume("dumpling_3_press"));
    assert!((after / before - 1.0).abs() < 0.1, "{before} m³ became {after}");
}
