//! What the adjoint of one control step needs of it.
use super::neighbours::Lists;
use super::rigid::RigidMotion;
use crate::model::law::History;
use crate::state::Particles;
use glam::DVec3;
use std::sync::Arc;

/// One interval, in the order in which it happened.
#[derive(Default)]
pub(super) struct Tape {
    /// Every time that the laws of substeps were asked.
    pub(super) asked: Vec<Asked>,
    /// How each rigid body moved in every substep, where there are any.
    pub(super) rigid: Vec<Vec<RigidMotion>>,
    /// Velocities at the end of every substep \[m/s\], of integrators that do not ask about them.
    pub(super) velocities: Vec<Vec<DVec3>>,
}

/// What the laws of substeps were asked about at one time.
pub(super) struct Asked {
    pub(super) particles: Particles,
    /// What pairs they ran over.
    pub(super) lists: Arc<Lists>,
    /// How far the tool had come, of its way.
    pub(super) fraction: f64,
    /// Time since they were asked before \[s\].
    pub(super) duration: f64,
    /// What each law remembered then, and what it remembers now.
    pub(super) before: Vec<History>,
    pub(super) after: Vec<History>,
}
