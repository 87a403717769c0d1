//! Episodes: what the world did under random actions, on disk and in memory.
use crate::state::{Control, Pose, Rollout};

/// One tool action in the world, seen at every control step.
#[derive(Clone, Debug, PartialEq)]
pub struct Episode {
    /// Name of the tool, its config's file stem.
    pub tool: String,
    /// The action θ.
    pub theta: Vec<f64>,
    /// Duration of a control step \[s\].
    pub interval: f64,
    /// Pose of each tool part at the start.
    pub start: Vec<Pose>,
    /// H controls.
    pub controls: Vec<Control>,
    /// H + 1 states; velocities are backward differences, zero at the start.
    pub states: Rollout,
}
