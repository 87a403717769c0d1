//! A block of dough, tools, and how they move.
use glam::{DQuat, DVec2, DVec3};
use indexmap::IndexMap;
use pliant::data::random_action;
use pliant::state::{Control, Part, Pose, Solid, ToolShape};
use pliant::tool::{Motion, Tool, ToolSpec};
use pliant::world::{BlockSpec, DoughSpec, Filling, MaterialSpec, SceneSpec, SolverSpec, StartSpec, World};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::path::PathBuf;
use std::sync::Arc;

pub(crate) fn dough() -> DoughSpec {
    DoughSpec {
        density: 1200.0,
        young_modulus: 5e3,
        poisson_ratio: 0.499,
        damping_ratio: 1.0,
        yield_strain: 0.02,
        creep_rate: 60.0,
        largest_set: 0.8,
        friction: 0.5,
    }
}

pub(crate) fn spec() -> SceneSpec {
    SceneSpec {
        material: MaterialSpec::Dough(dough()),
        start: StartSpec::Block(BlockSpec { x: [0.06; 2], y: [0.06; 2], z: [0.03; 2], turn: [0.0; 2] }),
        spacing: 0.01,
        particles: 120,
        interval: 0.1,
        solver: SolverSpec { steps: 8, substeps: 8, sweeps: 4 },
        walls: None,
        beside: IndexMap::new(),
    }
}

pub(crate) fn tool(parts: &[Solid]) -> Arc<ToolShape> {
    let part = |solid: &Solid| Part { solid: solid.clone(), surface: Vec::new() };
    Arc::new(ToolShape::from(parts.iter().map(part).collect::<Vec<_>>()))
}

pub(crate) fn press() -> Arc<ToolShape> {
    tool(&[Solid::Cuboid { half: DVec3::new(0.02, 0.02, 0.01) }])
}

pub(crate) fn plate() -> Arc<ToolShape> {
    tool(&[Solid::Cuboid { half: DVec3::new(0.1, 0.1, 0.01) }])
}

pub(crate) fn fingers() -> Arc<ToolShape> {
    let finger = Solid::Cuboid { half: DVec3::new(0.0059, 0.01, 0.0253) };
    tool(&[finger.clone(), finger])
}

pub(crate) fn roller() -> Arc<ToolShape> {
    tool(&[Solid::Cylinder { radius: 0.02, half_length: 0.035 }])
}

pub(crate) fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose { translation: DVec3::new(x, y, z), rotation: DQuat::IDENTITY }
}

/// Through way points at (step, pose of each part), straight in between.
pub(crate) fn path(points: &[(usize, Vec<Pose>)]) -> Motion {
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
pub(crate) fn down_to(z: f64, below: f64) -> Motion {
    let up = vec![at(0.0, 0.0, 0.045 + below)];
    path(&[(0, up.clone()), (10, vec![at(0.0, 0.0, z + below)]), (15, up)])
}

pub(crate) fn grip(width: f64) -> Motion {
    let open = |gap: f64| vec![at(-gap / 2.0 - 0.0059, 0.0, 0.0303), at(gap / 2.0 + 0.0059, 0.0, 0.0303)];
    path(&[(0, open(0.09)), (10, open(width)), (15, open(0.09))])
}

pub(crate) fn roll(z: f64) -> Motion {
    let p =
        |x: f64, z: f64| Pose { translation: DVec3::new(x, 0.0, z + 0.02), rotation: DQuat::from_rotation_y(x / 0.02) };
    path(&[(0, vec![p(-0.03, 0.045)]), (4, vec![p(-0.03, z)]), (12, vec![p(0.03, z)]), (15, vec![p(0.03, 0.045)])])
}

/// Standard gravity \[m/s²\].
pub(crate) const GRAVITY: f64 = 9.81;

/// What the scene is made of, filling a box of `size` whose middle is at `at`, `raised` above the table and not yet settled.
pub(crate) fn standing(spec: &SceneSpec, size: DVec3, at: DVec2, raised: f64) -> World {
    let half = size / 2.0;
    let bounds = (-half.with_z(0.0), half.with_z(size.z));
    let filling = Filling { bounds, contains: &|_| true, turn: 0.0, at, raised };
    World::standing(spec, &filling, &mut ChaCha8Rng::seed_from_u64(1)).unwrap()
}

pub(crate) fn extent(points: &[DVec3]) -> DVec3 {
    let low = points.iter().fold(DVec3::INFINITY, |l, p| l.min(*p));
    points.iter().fold(DVec3::NEG_INFINITY, |h, p| h.max(*p)) - low
}

pub(crate) fn top(points: &[DVec3]) -> f64 {
    points.iter().map(|p| p.z).fold(0.0, f64::max)
}

pub(crate) fn middle(points: &[DVec3]) -> DVec3 {
    points.iter().sum::<DVec3>() / points.len() as f64
}

/// Every tool of `configs/tool`, by name.
pub(crate) fn shipped_tools() -> Vec<(String, Box<dyn Tool>)> {
    let mut files: Vec<_> = std::fs::read_dir("configs/tool").unwrap().map(|e| e.unwrap().path()).collect();
    files.sort();
    let read = |path: &PathBuf| {
        let spec: ToolSpec = toml_edit::de::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
        (path.file_stem().unwrap().to_string_lossy().into_owned(), spec.build().unwrap())
    };
    files.iter().map(read).collect()
}

/// The tool of `configs/tool` with this name.
pub(crate) fn shipped_tool(name: &str) -> Box<dyn Tool> {
    shipped_tools().into_iter().find(|(known, _)| known == name).expect("a shipped tool").1
}

/// A uniformly random action of `tool` on the dough.
pub(crate) fn random_motion(world: &World, tool: &dyn Tool, rng: &mut ChaCha8Rng) -> Motion {
    random_action(tool, &world.particles(), 15, rng).1
}
