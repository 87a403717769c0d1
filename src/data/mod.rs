//! Episodes: what the world did under random actions, on disk and in memory.
mod arrays;
mod check;
mod contents;
mod dataset;
mod episode;
mod export;
mod file;
mod histogram;
mod import;
mod info;
mod metadata;
mod simulate;
mod split;
mod statistics;
mod store;
mod sums;
mod vary;

pub use check::{Check, check};
pub use dataset::{Dataset, DatasetSpec};
pub use episode::Episode;
pub use export::{LAYOUTS, Layout, Trajectory, export};
pub use histogram::Histogram;
pub use import::{RECORDINGS, Recording, import};
pub use info::{Info, Usage};
pub use metadata::{Entry, Metadata};
pub use simulate::{random_action, record, simulate};
pub use split::{By, EpisodeSpec, GivenSpec, GroupSpec, HELD_OUT, HoldOut, Part, SizeSpec, SplitSpec};
pub use statistics::Statistics;
pub use store::store;
pub use vary::Ranges;

/// A small episode of `steps` control steps that is not physical at all, for tests.
#[cfg(test)]
fn made_up(steps: usize) -> Episode {
    use crate::state::{Control, Pose};
    use glam::{DQuat, DVec3, Vec3};
    let position =
        |t: usize, i: usize| Vec3::new(0.013 * i as f32, 0.001 * (i * t) as f32, 0.01 + 0.003 * t as f32).as_dvec3();
    let pose = |t: usize| Pose {
        translation: DVec3::new(0.1 * t as f64, 0.0, 0.05),
        rotation: DQuat::from_rotation_z(0.3 * t as f64),
    };
    let interval = 0.1;
    Episode {
        tool: "press".into(),
        theta: vec![0.01, -0.3],
        interval,
        start: vec![pose(0)],
        controls: (1..=steps).map(|t| Control { poses: vec![pose(t)] }).collect(),
        states: episode::states((0..=steps).map(|t| (0..5).map(|i| position(t, i)).collect()).collect(), interval),
        body: [0; 5].into(),
        walls: std::sync::Arc::default(),
        constants: std::sync::Arc::default(),
    }
}
