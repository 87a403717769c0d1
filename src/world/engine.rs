//! The physics engine: its whole state, and one step of it.
use super::lattice::Lattice;
use super::scale::{GRAVITY, length, outward};
use super::{SceneSpec, dough, hand};
use crate::state::{Pose, ToolShape};
use glam::DVec3;
use rapier3d::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// Half the side of the table, and its thickness \[m\].
const TABLE: (f64, f64) = (2.0, 0.5);

/// Rapier's world and the handles into it.
#[derive(Serialize, Deserialize)]
pub(super) struct Engine {
    physics: PhysicsWorld,
    dough: SoftBodyHandle,
    hand: Vec<RigidBodyHandle>,
    friction: Real,
}

impl Engine {
    pub(super) fn new(spec: &SceneSpec, lattice: &Lattice, lift: f64) -> Self {
        let friction = spec.material.friction as Real;
        let mut physics = PhysicsWorld::new();
        physics.gravity = Vector::NEG_Z * length(GRAVITY);
        physics.integration_parameters = parameters(spec);
        let (half, thickness) = (length(TABLE.0), length(TABLE.1));
        physics.insert(
            RigidBodyBuilder::fixed().translation(Vector::NEG_Z * (thickness / 2.0)),
            ColliderBuilder::cuboid(half, half, thickness / 2.0).friction(friction),
        );
        let dough = physics.insert_soft_body(dough::body(spec, lattice, lift));
        Self { physics, dough, hand: Vec::new(), friction }
    }

    /// Replaces the tool in hand.
    pub(super) fn hold(&mut self, tool: &ToolShape, poses: &[Pose]) {
        hand::release(&mut self.physics, &self.hand);
        self.hand = hand::hold(&mut self.physics, tool, poses, self.friction);
    }

    /// One physics step, at the end of which the tool's parts stand at `poses`.
    pub(super) fn step(&mut self, poses: impl Iterator<Item = Pose>) {
        hand::carry(&mut self.physics, &self.hand, poses);
        self.physics.step();
    }

    pub(super) fn positions(&self) -> impl Iterator<Item = DVec3> + '_ {
        self.body().particle_positions().map(outward)
    }

    pub(super) fn surface(&self) -> impl Iterator<Item = DVec3> + '_ {
        let corners: BTreeSet<u32> = self.body().boundary().iter().flatten().copied().collect();
        corners.into_iter().map(|i| outward(self.body().particle_position(i as usize)))
    }

    pub(super) fn volume(&self) -> f64 {
        let tetrahedra: Vec<_> = self.body().cells().iter().map(|c| c.vertices).collect();
        dough::total_volume(&tetrahedra, &self.positions().collect::<Vec<_>>())
    }

    fn body(&self) -> &SoftBody {
        &self.physics.soft_bodies[self.dough]
    }
}

/// The engine's clone of everything but its scratch memory, which it may begin afresh at any step.
impl Clone for Engine {
    fn clone(&self) -> Self {
        let from = &self.physics;
        let physics = PhysicsWorld {
            gravity: from.gravity,
            integration_parameters: from.integration_parameters,
            physics_pipeline: PhysicsPipeline::new(),
            collision_pipeline: CollisionPipeline::new(),
            islands: from.islands.clone(),
            broad_phase: from.broad_phase.clone(),
            narrow_phase: from.narrow_phase.clone(),
            bodies: from.bodies.clone(),
            colliders: from.colliders.clone(),
            impulse_joints: from.impulse_joints.clone(),
            multibody_joints: from.multibody_joints.clone(),
            soft_bodies: from.soft_bodies.clone(),
            ccd_solver: CCDSolver::new(),
        };
        Self { physics, dough: self.dough, hand: self.hand.clone(), friction: self.friction }
    }
}

/// The detection of crossings serves soft bodies that meet themselves or each other; dough is one body without self contacts.
fn parameters(spec: &SceneSpec) -> IntegrationParameters {
    let mut parameters = IntegrationParameters {
        dt: (spec.interval / spec.solver.steps as f64) as Real,
        num_solver_iterations: spec.solver.substeps,
        num_internal_pgs_iterations: 1,
        ..IntegrationParameters::default()
    };
    let soft = &mut parameters.soft_bodies;
    soft.max_extra_substeps = 0;
    soft.recovery.inverted_cell_detection = false;
    soft.recovery.self_crossing_detection = false;
    soft.recovery.cross_body_detection = false;
    parameters
}
