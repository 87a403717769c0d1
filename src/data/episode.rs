//! One recorded tool action.
use crate::state::{Constants, Control, MEMORY, Particles, Pose, Rollout, Scene, ToolShape, Wall};
use glam::DVec3;
use std::sync::Arc;

/// One tool action in the world, seen at every control step.
#[derive(Clone, Debug, PartialEq)]
pub struct Episode {
    /// Name of the tool, its config's file stem.
    pub tool: String,
    /// The action θ.
    pub theta: Vec<f64>,
    /// Duration of a control step \[s\].
    pub interval: f64,
    /// Pose of each tool part at the start; none in recordings without a tool.
    pub start: Vec<Pose>,
    /// H controls.
    pub controls: Vec<Control>,
    /// H + 1 states; velocities are backward differences, zero at the start.
    pub states: Rollout,
    /// Number of the body that each particle belongs to, N rows; 0 where there is but one.
    pub body: Arc<[u32]>,
    /// Walls around the table.
    pub walls: Arc<[Wall]>,
    /// What the dataset drew for it, which its file does not hold.
    pub constants: Arc<Constants>,
}

impl Episode {
    /// Number of control steps H.
    pub fn horizon(&self) -> usize {
        self.controls.len()
    }

    /// Pose of each tool part after `t` control steps.
    pub fn poses(&self, t: usize) -> &[Pose] {
        if t == 0 { &self.start } else { &self.controls[t - 1].poses }
    }

    /// What a model is told to start from the state after `t` control steps; `tool` is the shape of this episode's tool.
    pub fn scene(&self, t: usize, tool: &Arc<ToolShape>) -> Scene {
        Scene {
            particles: self.states[t].clone(),
            past: self.states[..t].iter().rev().take(MEMORY).map(|x| x.velocities.clone()).collect(),
            body: Arc::clone(&self.body),
            walls: Arc::clone(&self.walls),
            constants: Arc::clone(&self.constants),
            tool: tool.clone(),
            poses: self.poses(t).to_vec(),
            interval: self.interval,
            snapshot: None,
        }
    }
}

/// States from recorded positions: velocities are backward differences \[m/s\], zero at the start.
pub(super) fn states(positions: Vec<Vec<DVec3>>, interval: f64) -> Rollout {
    let mut states: Rollout = Vec::with_capacity(positions.len());
    for positions in positions {
        let velocities = match states.last() {
            Some(before) => positions.iter().zip(&before.positions).map(|(b, a)| (b - a) / interval).collect(),
            None => vec![DVec3::ZERO; positions.len()],
        };
        states.push(Particles { positions, velocities });
    }
    states
}
