//! What a model is told before it starts, and what it is told at each step.
use super::{Particles, ParticlesGrad, Pose, PoseGrad, ToolShape, Wall};
use anyhow::ensure;
use glam::DVec3;
use indexmap::IndexMap;
use std::sync::Arc;

/// The most velocities of the past that a scene is given.
pub const MEMORY: usize = 8;

/// Constants of a scene by their path in its config, such as `material.young_modulus`, in the unit they have there.
pub type Constants = IndexMap<String, f64>;

/// The start of a rollout: particles, and the tool where its motion begins.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Object particles.
    pub particles: Particles,
    /// Velocities one, two … control steps before \[m/s\], N rows each, as far as they are known; before that all was at rest.
    pub past: Vec<Vec<DVec3>>,
    /// Number of the body that each particle belongs to, N rows; all 0 where there is but one.
    pub body: Arc<[u32]>,
    /// Walls around the table.
    pub walls: Arc<[Wall]>,
    /// Constants of the materials that a model may be told.
    pub constants: Arc<Constants>,
    /// Geometry of the tool's parts.
    pub tool: Arc<ToolShape>,
    /// Pose of each part at the start.
    pub poses: Vec<Pose>,
    /// Duration of one control step \[s\].
    pub interval: f64,
    /// The simulator's own state at this instant, for the models that need it (the oracle).
    pub snapshot: Option<Snapshot>,
}

impl Scene {
    /// One body of particles on an open table, with no simulator behind it.
    pub fn open(particles: Particles, tool: Arc<ToolShape>, poses: Vec<Pose>, interval: f64) -> Self {
        let body = vec![0; particles.len()].into();
        let (past, walls, constants) = (Vec::new(), Arc::default(), Arc::default());
        Self { particles, past, body, walls, constants, tool, poses, interval, snapshot: None }
    }

    /// What the next motion starts from once this scene has become `particles`: they lie still, and the tool is laid aside.
    pub fn after(&self, particles: &Particles, snapshot: Option<Snapshot>) -> Self {
        let particles = Particles::at_rest(particles.positions.clone());
        Self { particles, past: Vec::new(), snapshot, ..self.clone() }
    }

    /// Whether the parts of the scene fit each other and all its numbers are finite.
    ///
    /// # Errors
    /// A sentence naming what does not.
    pub fn check(&self) -> anyhow::Result<()> {
        let (poses, parts) = (self.poses.len(), self.tool.parts.len());
        ensure!(poses == parts, "the scene gives {poses} tool poses for a tool of {parts} parts");
        ensure!(self.interval > 0.0, "the scene's control interval must be positive, got {} s", self.interval);
        let (positions, velocities) = (self.particles.positions.len(), self.particles.velocities.len());
        ensure!(positions == velocities, "the scene gives {positions} positions but {velocities} velocities");
        let past = self.past.iter().all(|rows| rows.len() == positions);
        ensure!(past, "the scene gives {positions} particles, but velocities in the past of more or fewer");
        let bodies = self.body.len();
        ensure!(positions == bodies, "the scene gives {positions} particles but the bodies of {bodies}");
        ensure!(self.particles.is_finite(), "a particle's position or velocity in the scene is not a finite number");
        Ok(())
    }
}

/// A simulator's state as bytes that only it can read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Snapshot(pub Arc<[u8]>);

/// Where each rigid tool part stands at the end of a control interval; in between it moves at constant twist.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Control {
    /// One pose per part.
    pub poses: Vec<Pose>,
}

/// `∂J/∂control`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ControlGrad {
    /// One per part.
    pub poses: Vec<PoseGrad>,
}

/// `∂J/∂scene`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SceneGrad {
    /// `∂J/∂particles`.
    pub particles: ParticlesGrad,
    /// `∂J/∂(start poses)`, one per part.
    pub poses: Vec<PoseGrad>,
}
