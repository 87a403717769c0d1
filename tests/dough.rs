//! The analytical dough, pressed to half its height: it spreads, does not bounce, and keeps its shape.
use glam::DVec3;
use pliant::model::{ModelSpec, WorldModel};
use pliant::state::{Control, Part, Particles, Pose, Scene, Solid, ToolShape};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Deserialize;
use std::sync::Arc;

#[derive(Deserialize)]
struct Contender {
    dynamics: ModelSpec,
}

fn analytic() -> Box<dyn WorldModel> {
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/configs/model/analytic.toml")).unwrap();
    toml_edit::de::from_str::<Contender>(&text).unwrap().dynamics.build().unwrap()
}

/// A block of 6 × 6 × 3 cm, its particles 8 mm apart give or take 1 mm.
fn block() -> Vec<DVec3> {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let (spacing, count) = (0.06 / 7.5, [7, 7, 4]);
    let mut points = Vec::new();
    for z in 0..count[2] {
        for y in 0..count[1] {
            for x in 0..count[0] {
                let grid = DVec3::new(x as f64 - 3.0, y as f64 - 3.0, z as f64 + 0.5) * spacing;
                let jitter = DVec3::from_array(rng.random::<[f64; 3]>()) - 0.5;
                points.push(grid + 0.002 * jitter);
            }
        }
    }
    points
}

fn extent(particles: &Particles) -> (f64, f64) {
    let mut heights: Vec<f64> = particles.positions.iter().map(|x| x.z).collect();
    let mut widths: Vec<f64> = particles.positions.iter().map(|x| x.x.abs()).collect();
    heights.sort_by(f64::total_cmp);
    widths.sort_by(f64::total_cmp);
    let at = |v: &[f64]| v[(0.95 * v.len() as f64) as usize];
    (at(&heights), 2.0 * at(&widths))
}

#[test]
fn look() {
    let model = analytic();
    let scene = Scene {
        particles: Particles::at_rest(block()),
        tool: Arc::new(ToolShape {
            parts: vec![Part { solid: Solid::Cuboid { half: DVec3::new(0.05, 0.05, 0.01) }, surface: Vec::new() }],
        }),
        poses: vec![Pose { translation: DVec3::Z * 0.046, ..Pose::default() }],
        interval: 0.1,
        snapshot: None,
    };
    let at = |z: f64| Control { poses: vec![Pose { translation: DVec3::Z * z, ..Pose::default() }] };
    let mut controls: Vec<Control> = (1..=10).map(|t| at(0.046 - 0.02 * t as f64 / 10.0)).collect();
    controls.extend((1..=5).map(|t| at(0.026 + 0.03 * t as f64 / 5.0)));
    controls.extend((1..=15).map(|_| at(0.056)));
    let clock = std::time::Instant::now();
    let rollout = model.rollout(&scene, &controls);
    eprintln!("{:?} for {} steps", clock.elapsed(), controls.len());
    for (t, x) in rollout.iter().enumerate() {
        let speed = x.velocities.iter().map(|v| v.length()).fold(0.0, f64::max);
        let mean: f64 = x.velocities.iter().map(|v| v.length()).sum::<f64>() / x.len() as f64;
        let low = x.positions.iter().map(|v| v.z).fold(1.0, f64::min);
        let e = extent(x);
        eprintln!("{t:3} height {:.4} width {:.4} low {:.4} speed {:.4} mean {:.5}", e.0, e.1, low, speed, mean);
    }
    let still: Vec<Control> = (0..30).map(|_| at(0.1)).collect();
    let rest = model.rollout(&scene, &still);
    for t in [0, 1, 2, 5, 15, 30] {
        eprintln!("rest {t} {:?}", extent(&rest[t]));
    }
}
