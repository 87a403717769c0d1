//! The layout of LagrangeBench (Toshev et al. 2023).
use super::{Layout, Metadata, Trajectory};
use anyhow::{Context, ensure};
use hdf5_pure::FileBuilder;
use serde_json::{Value as Json, json};

/// `train.h5`, `valid.h5`, `test.h5`: a group a trajectory, `00000` and on, with `position` (frames, particles, 3) float32 and
/// `particle_type` (particles) int64.
///
/// Type 2 is a moving wall there and holds the tool; body 0 is fluid, 0, and the others are rigid or further bodies, 3, 4 ….
pub(super) struct LagrangebenchH5;

/// The type whose particles' motion is given.
const MOVING_WALL: i64 = 2;

impl Layout for LagrangebenchH5 {
    fn name(&self) -> &'static str {
        "lagrangebench-h5"
    }

    fn ending(&self) -> &'static str {
        "h5"
    }

    fn free(&self, body: u32) -> i64 {
        if body == 0 { 0 } else { i64::from(body) + MOVING_WALL }
    }

    fn driven(&self) -> i64 {
        MOVING_WALL
    }

    fn bytes(&self, trajectories: &[Trajectory]) -> anyhow::Result<Vec<u8>> {
        let first = trajectories.first().map_or(0, |t| t.frames);
        let odd = trajectories.iter().find(|t| t.frames != first);
        ensure!(
            odd.is_none(),
            "one trajectory has {first} frames and another {}; this layout needs equally many in each",
            odd.map_or(0, |t| t.frames)
        );
        let mut file = FileBuilder::new();
        for (k, Trajectory { positions, frames, types }) in trajectories.iter().enumerate() {
            let mut group = file.create_group(&format!("{k:05}"));
            let shape = [*frames as u64, types.len() as u64, 3];
            group.create_dataset("position").with_f32_data(positions).with_shape(&shape);
            group.create_dataset("particle_type").with_i64_data(types);
            file.add_group(group.finish());
        }
        file.finish().context("the trajectories cannot be written as HDF5")
    }

    fn metadata(&self, metadata: &Metadata, most: usize) -> Json {
        // The keys are LagrangeBench's already, but for what only Pliant says.
        let mut json = json!(metadata);
        if let Some(keys) = json.as_object_mut() {
            ["episodes", "spec", "split", "seed"].iter().for_each(|key| drop(keys.remove(*key)));
            keys.insert("num_particles_max".to_owned(), json!(most));
        }
        json
    }
}
