//! Materials: what a scene is filled with, and how the engine holds it.
use super::bodies::Bodies;
use super::dough::Dough;
use super::grains::GrainsSpec;
use super::lattice::Lattice;
use super::rigid::RigidSpec;
use super::{DoughSpec, SceneSpec};
use glam::{DQuat, DVec3};
use rand_chacha::ChaCha8Rng;
use rapier3d::prelude::{IntegrationParameters, PhysicsWorld};
use serde::{Deserialize, Serialize};

/// Where a material goes: the part of a box that a predicate holds.
pub struct Filling<'a> {
    /// Corners of the box, before turning \[m\].
    pub bounds: (DVec3, DVec3),
    /// Whether a point is inside, before turning.
    pub contains: &'a dyn Fn(DVec3) -> bool,
    /// Turn about z \[rad\].
    pub turn: f64,
    /// Height above the table at which its lowest point begins \[m\].
    pub raised: f64,
}

impl Filling<'_> {
    /// The lattice that fills it, its lowest corner `above` the height at which the material begins \[m\].
    ///
    /// # Errors
    /// As [`Lattice::fill`].
    pub(super) fn lattice(&self, spacing: f64, above: f64) -> anyhow::Result<Lattice> {
        let mut lattice = Lattice::fill(self.contains, self.bounds, spacing)?;
        let lowest = lattice.corners.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
        let (turn, rise) = (DQuat::from_rotation_z(self.turn), (self.raised + above - lowest) * DVec3::Z);
        lattice.corners.iter_mut().for_each(|corner| *corner = turn * *corner + rise);
        Ok(lattice)
    }
}

/// A kind of material.
pub trait Material: Send + Sync {
    /// Puts the material into the engine; what is drawn at random comes from `rng`.
    ///
    /// # Errors
    /// A sentence saying why the region or the scene is impossible.
    fn fill(
        &self,
        scene: &SceneSpec,
        filling: &Filling<'_>,
        physics: &mut PhysicsWorld,
        rng: &mut ChaCha8Rng,
    ) -> anyhow::Result<Matter>;
    /// Coulomb friction coefficient against table and tools.
    fn friction(&self) -> f64;
    /// Changes the solver's parameters to what the material needs.
    fn tune(&self, scene: &SceneSpec, parameters: &mut IntegrationParameters) {
        parameters.num_internal_pgs_iterations = scene.solver.sweeps;
    }
    /// How long new material settles on the table \[s\].
    fn settling(&self) -> f64;
}

family! {
    /// What a scene is made of.
    MaterialSpec builds Box<dyn Material> { Dough(DoughSpec), Grains(GrainsSpec), Rigid(RigidSpec) }
}

/// A material in the engine: handles, which a snapshot keeps.
#[derive(Clone, Serialize, Deserialize)]
pub enum Matter {
    /// A soft body.
    Dough(Dough),
    /// Rigid bodies.
    Bodies(Bodies),
}

/// What the world asks of a material in the engine.
pub(super) trait Substance {
    /// All particles of the simulator \[m\].
    fn positions(&self, physics: &PhysicsWorld) -> Vec<DVec3>;
    /// Those on its surface \[m\].
    fn surface(&self, physics: &PhysicsWorld) -> Vec<DVec3>;
    /// Its volume \[m³\].
    fn volume(&self, physics: &PhysicsWorld) -> f64;
    /// Adds a velocity \[m/s\] to all of it.
    fn kick(&self, velocity: DVec3, physics: &mut PhysicsWorld);
    /// Mends after a physics step what contacts left through the table.
    fn lift(&self, _: &mut PhysicsWorld) {}
    /// Has the next step read its particles anew, as after [`Substance::lift`]; a mark that no serialisation keeps.
    fn refresh(&self, _: &mut PhysicsWorld) {}
}

impl Matter {
    pub(super) fn substance(&self) -> &dyn Substance {
        match self {
            Self::Dough(dough) => dough,
            Self::Bodies(bodies) => bodies,
        }
    }
}
