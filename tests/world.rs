//! The ground truth: dough rests, yields, keeps its volume and the table its place; and a world's future is its state's alone.
use glam::{DQuat, DVec3};
use pliant::model::{Oracle, WorldModel};
use pliant::state::{Control, Part, Pose, Rollout, Snapshot, Solid, ToolShape};
use pliant::tool::Motion;
use pliant::world::{BlockSpec, EllipsoidSpec, MaterialSpec, SceneSpec, SolverSpec, StartSpec, World};
use rayon::prelude::*;
use std::sync::Arc;

const SKIN: f64 = 0.0025;

fn spec() -> SceneSpec {
    SceneSpec {
        material: MaterialSpec {
            density: 1200.0,
            young_modulus: 2e4,
            poisson_ratio: 0.499,
            damping_ratio: 1.0,
            yield_strain: 0.02,
            creep_rate: 60.0,
            largest_set: 0.8,
            friction: 0.5,
        },
        start: StartSpec::Block(BlockSpec { x: [0.06; 2], y: [0.06; 2], z: [0.03; 2], turn: [0.0; 2] }),
        spacing: 0.01,
        particles: 120,
        interval: 0.1,
        solver: SolverSpec { steps: 4, substeps: 4, sweeps: 4 },
    }
}

fn tool(parts: &[Solid]) -> Arc<ToolShape> {
    let part = |solid: &Solid| Part { solid: solid.clone(), surface: Vec::new() };
    Arc::new(ToolShape { parts: parts.iter().map(part).collect() })
}

fn press() -> Arc<ToolShape> {
    tool(&[Solid::Cuboid { half: DVec3::new(0.02, 0.02, 0.01) }])
}

fn plate() -> Arc<ToolShape> {
    tool(&[Solid::Cuboid { half: DVec3::new(0.1, 0.1, 0.01) }])
}

fn fingers() -> Arc<ToolShape> {
    let finger = Solid::Cuboid { half: DVec3::new(0.0059, 0.01, 0.0253) };
    tool(&[finger.clone(), finger])
}

fn roller() -> Arc<ToolShape> {
    tool(&[Solid::Cylinder { radius: 0.02, half_length: 0.035 }])
}

fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose { translation: DVec3::new(x, y, z), rotation: DQuat::IDENTITY }
}

/// Through way points at (step, pose of each part), straight in between.
fn path(points: &[(usize, Vec<Pose>)]) -> Motion {
    let leg = |pair: &[(usize, Vec<Pose>)]| -> Vec<Control> {
        let ((from, a), (to, b)) = (&pair[0], &pair[1]);
        let way = |i| (i - from) as f64 / (to - from) as f64;
        (from + 1..=*to)
            .map(|i| Control { poses: a.iter().zip(b).map(|(a, b)| a.toward(b, way(i))).collect() })
            .collect()
    };
    Motion { start: points[0].1.clone(), controls: points.windows(2).flat_map(leg).collect() }
}

/// Down until the tool's lower face, `below` its origin, is at height z; then up again.
fn down_to(z: f64, below: f64) -> Motion {
    let up = vec![at(0.0, 0.0, 0.045 + below)];
    path(&[(0, up.clone()), (10, vec![at(0.0, 0.0, z + below)]), (15, up)])
}

fn grip(width: f64) -> Motion {
    let open = |gap: f64| vec![at(-gap / 2.0 - 0.0059, 0.0, 0.0303), at(gap / 2.0 + 0.0059, 0.0, 0.0303)];
    path(&[(0, open(0.09)), (10, open(width)), (15, open(0.09))])
}

fn roll(z: f64) -> Motion {
    let p =
        |x: f64, z: f64| Pose { translation: DVec3::new(x, 0.0, z + 0.02), rotation: DQuat::from_rotation_y(x / 0.02) };
    path(&[(0, vec![p(-0.03, 0.045)]), (4, vec![p(-0.03, z)]), (12, vec![p(0.03, z)]), (15, vec![p(0.03, 0.045)])])
}

fn extent(points: &[DVec3]) -> DVec3 {
    let low = points.iter().fold(DVec3::INFINITY, |l, p| l.min(*p));
    points.iter().fold(DVec3::NEG_INFINITY, |h, p| h.max(*p)) - low
}

fn report(name: &str, world: &World) {
    let all = world.all_positions();
    let low = all.iter().map(|p| p.z).fold(9.0, f64::min);
    println!("{name:12} extent {:.4?} lowest {low:.5} volume {:.2} cm3", extent(&all).to_array(), world.volume() * 1e6);
}

#[test]
fn trial() {
    for (name, tool, motion) in [
        ("plate", plate(), down_to(0.015, 0.01)),
        ("press", press(), down_to(0.015, 0.01)),
        ("grip", fingers(), grip(0.02)),
        ("roll", roller(), roll(0.015)),
    ] {
        let t = std::time::Instant::now();
        let mut world = World::new(&spec(), 1).unwrap();
        println!("new {:?}", t.elapsed());
        report(name, &world);
        let t = std::time::Instant::now();
        let scene = world.scene(&tool, &motion.start);
        println!("scene {:?} {} bytes", t.elapsed(), scene.snapshot.as_ref().unwrap().0.len());
        let t = std::time::Instant::now();
        World::restore(scene.snapshot.as_ref().unwrap()).unwrap();
        println!("restore {:?}", t.elapsed());
        let t = std::time::Instant::now();
        let _ = world.clone();
        println!("clone {:?}", t.elapsed());
        let t = std::time::Instant::now();
        let rollout = world.execute(&tool, &motion);
        println!("execute {:?}", t.elapsed());
        report(name, &world);
        let t = std::time::Instant::now();
        let predicted = Oracle.rollout(&scene, &motion.controls);
        println!("oracle {:?}", t.elapsed());
        assert!(predicted == rollout);
    }
}
