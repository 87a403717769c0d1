//! The layout of graph network simulators (Sanchez-Gonzalez et al. 2020), as its PyTorch port reads it.
use super::super::arrays::Draft;
use super::pickle::object_array;
use super::{Layout, Metadata, Trajectory};
use serde_json::{Value as Json, json};

/// `train.npz`, `valid.npz`, `test.npz`: one entry a trajectory, `simulation_trajectory_0` and on, an object array of its positions
/// (frames, particles, 3) float32 and its particle types (particles) int64; `numpy.load` needs `allow_pickle=True`, which the port
/// passes.
///
/// Type 3 is kinematic there and holds the tool; the bodies are 0, 1, 2, 4, 5 ….
pub(super) struct GnsNpz;

/// The type whose particles' motion is given.
const KINEMATIC: i64 = 3;

impl Layout for GnsNpz {
    fn name(&self) -> &'static str {
        "gns-npz"
    }

    fn ending(&self) -> &'static str {
        "npz"
    }

    fn free(&self, body: u32) -> i64 {
        let body = i64::from(body);
        if body < KINEMATIC { body } else { body + 1 }
    }

    fn driven(&self) -> i64 {
        KINEMATIC
    }

    fn bytes(&self, trajectories: &[Trajectory]) -> anyhow::Result<Vec<u8>> {
        let mut draft = Draft::new();
        for (k, trajectory) in trajectories.iter().enumerate() {
            draft.add_bytes(&format!("simulation_trajectory_{k}"), &object_array(trajectory)?)?;
        }
        draft.bytes()
    }

    fn metadata(&self, metadata: &Metadata, _: usize) -> Json {
        let statistics = &metadata.statistics;
        let mut bounds = metadata.bounds;
        // A wall in this layout, and the only one there is is the table.
        bounds[2][0] = 0.0;
        json!({
            "bounds": bounds,
            "sequence_length": metadata.sequence_length_train,
            "default_connectivity_radius": metadata.default_connectivity_radius,
            "dim": metadata.dim,
            "dt": metadata.dt,
            "vel_mean": statistics.vel_mean,
            "vel_std": statistics.vel_std,
            "acc_mean": statistics.acc_mean,
            "acc_std": statistics.acc_std,
        })
    }
}
