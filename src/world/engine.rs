//! The physics engine: its whole state, and one step of it.
use super::hand::Hand;
use super::material::{Filling, Material, Matter};
use super::scale::{GRAVITY, length};
use super::{SceneSpec, WallsSpec};
use crate::state::{Pose, ToolShape, Wall};
use glam::DVec3;
use rand_chacha::ChaCha8Rng;
use rapier3d::prelude::*;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

/// Rapier's world and the handles into it.
#[derive(Serialize, Deserialize)]
pub(super) struct Engine {
    physics: PhysicsWorld,
    matter: Vec<Matter>,
    hand: Hand,
    friction: Real,
}

impl Engine {
    /// An empty table, and walls where `spec` has them; `materials` are what will be put on it.
    pub(super) fn new(spec: &SceneSpec, materials: &[Box<dyn Material>]) -> Self {
        let friction = materials.iter().map(|material| material.friction() as Real).fold(0.0, Real::max);
        let mut physics = PhysicsWorld::new();
        physics.gravity = Vector::NEG_Z * length(GRAVITY);
        physics.integration_parameters = IntegrationParameters {
            dt: (spec.interval / spec.solver.steps as f64) as Real,
            num_solver_iterations: spec.solver.substeps,
            ..IntegrationParameters::default()
        };
        materials.iter().for_each(|material| material.tune(spec, &mut physics.integration_parameters));
        let walls = spec.walls.iter().flat_map(WallsSpec::planes);
        for plane in std::iter::once(Wall::FLOOR).chain(walls) {
            let normal = plane.normal.as_vec3();
            let collider = ColliderBuilder::new(SharedShape::halfspace(normal)).friction(friction);
            physics.insert(RigidBodyBuilder::fixed().translation(normal * length(plane.offset)), collider);
        }
        Self { physics, matter: Vec::new(), hand: Hand::default(), friction }
    }

    /// Puts a material where `filling` says.
    ///
    /// # Errors
    /// As [`Material::fill`].
    pub(super) fn add(
        &mut self,
        spec: &SceneSpec,
        material: &dyn Material,
        filling: &Filling<'_>,
        rng: &mut ChaCha8Rng,
    ) -> anyhow::Result<()> {
        self.matter.push(material.fill(spec, filling, &mut self.physics, rng)?);
        Ok(())
    }

    /// Replaces the tool in hand.
    pub(super) fn hold(&mut self, tool: &ToolShape, poses: &[Pose]) {
        self.hand.release(&mut self.physics);
        self.hand = Hand::hold(&mut self.physics, tool, poses, self.friction);
        for matter in &mut self.matter {
            matter.substance_mut().face(&self.physics, tool.cuts);
        }
    }

    /// One physics step, at the end of which the tool's parts stand at `poses`.
    pub(super) fn step(&mut self, poses: &[Pose]) {
        self.hand.carry(&mut self.physics, poses);
        for (part, blade) in &self.hand.blades {
            let Some(pose) = poses.get(*part as usize) else { continue };
            for matter in &mut self.matter {
                matter.substance_mut().cut(&mut self.physics, blade, pose);
            }
        }
        self.physics.step();
        for matter in &mut self.matter {
            matter.substance_mut().mend(&mut self.physics, &self.hand.parts);
        }
    }

    /// As [`Substance::kick`] of one piece.
    pub(super) fn kick(&mut self, piece: usize, velocity: &dyn Fn(DVec3) -> DVec3) {
        self.matter[piece].substance_mut().kick(velocity, &mut self.physics);
    }

    /// As [`Substance::shift`] of every piece.
    pub(super) fn shift(&mut self, by: &dyn Fn(DVec3) -> DVec3) {
        self.matter.iter_mut().for_each(|matter| matter.substance_mut().shift(by, &mut self.physics));
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

    /// Has the next step read the material's particles anew; a mark that no serialisation keeps.
    pub(super) fn refresh(&mut self) {
        for matter in &mut self.matter {
            matter.substance_mut().refresh(&mut self.physics);
        }
    }

    /// Of every piece, its particles \[m\].
    pub(super) fn pieces(&self) -> impl Iterator<Item = Vec<DVec3>> {
        self.matter.iter().map(|matter| matter.substance().positions(&self.physics))
    }

    /// Of every piece and every particle in it, the number of its body within the piece.
    pub(super) fn bodies(&self) -> impl Iterator<Item = Vec<usize>> {
        self.matter.iter().map(|matter| matter.substance().bodies())
    }

    /// Of every particle, the number of its piece.
    pub(super) fn owners(&self) -> Vec<usize> {
        self.pieces().enumerate().flat_map(|(k, points)| std::iter::repeat_n(k, points.len())).collect()
    }

    pub(super) fn surface(&self) -> Vec<DVec3> {
        self.matter.iter().flat_map(|matter| matter.substance().surface(&self.physics)).collect()
    }

    /// Of every piece, its volume \[m³\].
    pub(super) fn volumes(&self) -> impl Iterator<Item = f64> {
        self.matter.iter().map(|matter| matter.substance().volume(&self.physics))
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
        Self { physics, matter: self.matter.clone(), hand: self.hand.clone(), friction: self.friction }
    }
}
