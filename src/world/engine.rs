//! The physics engine: its whole state, and one step of it.
use super::lattice::Lattice;
use super::scale::{GRAVITY, length, outward};
use super::{SceneSpec, dough, hand};
use crate::state::{Pose, ToolShape};
use glam::DVec3;
use rapier3d::prelude::*;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

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
        let table = ColliderBuilder::new(SharedShape::halfspace(Vector::Z)).friction(friction);
        physics.insert(RigidBodyBuilder::fixed(), table);
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
        self.lift();
    }

    /// Contacts give way a little, and dough pinched between a tool and the table could be pushed through it: a particle
    /// below the table is put back onto it.
    fn lift(&mut self) {
        let body = &mut self.physics.soft_bodies[self.dough];
        for i in 0..body.num_particles() {
            let (position, velocity) = (body.particle_position(i), body.particle_velocity(i));
            if position.z < 0.0 {
                body.set_particle_position(i, position.with_z(0.0));
                body.set_particle_velocity(i, velocity.with_z(velocity.z.max(0.0)));
            }
        }
    }

    /// Drops what the engine's serialisation leaves out of soft bodies and contacts, such as how far the fit of a rest shape
    /// has come.
    ///
    /// Done at the end of every control step it makes a world equal to the one that its snapshot restores.
    pub(super) fn forget(&mut self) {
        self.physics.soft_bodies = again(&self.physics.soft_bodies);
        self.physics.narrow_phase = again(&self.physics.narrow_phase);
        self.refresh();
    }

    /// Has the next step read the dough's particles anew, as after [`Engine::lift`]; a mark that no serialisation keeps.
    pub(super) fn refresh(&mut self) {
        let body = &mut self.physics.soft_bodies[self.dough];
        body.set_particle_position(0, body.particle_position(0));
    }

    pub(super) fn positions(&self) -> impl Iterator<Item = DVec3> + '_ {
        self.body().particle_positions().map(outward)
    }

    pub(super) fn surface(&self) -> impl Iterator<Item = DVec3> + '_ {
        let corners: BTreeSet<u32> = self.body().boundary().iter().flatten().copied().collect();
        corners.into_iter().map(|i| outward(self.body().particle_position(i as usize)))
    }

    pub(super) fn volume(&self) -> f64 {
        let corner = |i: u32| outward(self.body().particle_position(i as usize));
        let under = |t: &[u32; 3]| corner(t[0]).dot(corner(t[1]).cross(corner(t[2]))) / 6.0;
        self.body().boundary().iter().map(under).sum()
    }

    fn body(&self) -> &SoftBody {
        &self.physics.soft_bodies[self.dough]
    }
}

fn again<T: Serialize + DeserializeOwned>(state: &T) -> T {
    let bytes = postcard::to_stdvec(state).expect("plain data always has an encoding");
    postcard::from_bytes(&bytes).expect("it was encoded just before")
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

/// The detection of crossings serves soft bodies that meet themselves or each other, which this one never does; and sweeps
/// spent on it would be better spent on the dough's volume, as are those of the engine's stabilisation pass.
fn parameters(spec: &SceneSpec) -> IntegrationParameters {
    let mut parameters = IntegrationParameters {
        dt: (spec.interval / spec.solver.steps as f64) as Real,
        num_solver_iterations: spec.solver.substeps,
        num_internal_pgs_iterations: 1,
        num_internal_stabilization_iterations: 0,
        ..IntegrationParameters::default()
    };
    let soft = &mut parameters.soft_bodies;
    soft.max_extra_substeps = 0;
    soft.recovery.inverted_cell_detection = false;
    soft.recovery.self_crossing_detection = false;
    soft.recovery.cross_body_detection = false;
    soft.recovery.overlap_constraints = false;
    parameters
}
