//! Materials: what a scene is filled with, and how the engine holds it.
use super::bodies::Bodies;
use super::dough::Dough;
use super::fluid::FluidSpec;
use super::grains::GrainsSpec;
use super::lattice::Lattice;
use super::liquid::Liquid;
use super::rigid::RigidSpec;
use super::{DoughSpec, SceneSpec};
use crate::state::{Blade, Pose};
use glam::{DQuat, DVec2, DVec3};
use rand_chacha::ChaCha8Rng;
use rapier3d::prelude::{IntegrationParameters, PhysicsWorld, RigidBodyHandle};
use serde::{Deserialize, Serialize};

/// Where a material goes: the part of a box that a predicate holds.
pub struct Filling<'a> {
    /// Corners of the box, before turning \[m\].
    pub bounds: (DVec3, DVec3),
    /// Whether a point is inside, before turning.
    pub contains: &'a dyn Fn(DVec3) -> bool,
    /// Turn about z \[rad\].
    pub turn: f64,
    /// Where the middle of the table comes to lie \[m\].
    pub at: DVec2,
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
        let (turn, shift) = (DQuat::from_rotation_z(self.turn), self.at.extend(self.raised + above - lowest));
        lattice.corners.iter_mut().for_each(|corner| *corner = turn * *corner + shift);
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
    MaterialSpec builds Box<dyn Material> { Dough(DoughSpec), Grains(GrainsSpec), Rigid(RigidSpec), Fluid(FluidSpec) }
}

/// Checks constants of a material, each (key, value, lowest, highest).
///
/// # Errors
/// A sentence naming the key whose value is impossible.
pub(super) fn check(constants: &[(&str, f64, f64, f64)]) -> anyhow::Result<()> {
    for (key, value, low, high) in constants {
        anyhow::ensure!((low..=high).contains(&value), "material.{key} is {value}; it must lie in [{low}, {high}]");
    }
    Ok(())
}

/// A material in the engine: what a snapshot keeps of it.
#[derive(Clone, Serialize, Deserialize)]
pub enum Matter {
    /// A soft body.
    Dough(Dough),
    /// Rigid bodies.
    Bodies(Bodies),
    /// A fluid beside the engine's own matter.
    Liquid(Liquid),
}

/// What the world asks of a material in the engine.
pub(super) trait Substance {
    /// All particles of the simulator \[m\].
    fn positions(&self, physics: &PhysicsWorld) -> Vec<DVec3>;
    /// Those on its surface \[m\].
    fn surface(&self, physics: &PhysicsWorld) -> Vec<DVec3>;
    /// Its volume \[m³\].
    fn volume(&self, physics: &PhysicsWorld) -> f64;
    /// Adds to every particle, or to every body as a whole, the velocity \[m/s\] that belongs to its place \[m\].
    fn kick(&mut self, velocity: &dyn Fn(DVec3) -> DVec3, physics: &mut PhysicsWorld);
    /// Moves every particle, or every body as a whole, by what belongs to its place \[m\].
    fn shift(&mut self, by: &dyn Fn(DVec3) -> DVec3, physics: &mut PhysicsWorld);
    /// The body of every particle: a connected lump, a grain; numbers from 0.
    fn bodies(&self) -> Vec<usize>;
    /// Prepares for a new tool, which may cut.
    fn face(&mut self, _: &PhysicsWorld, _cuts: bool) {}
    /// Parts what the blade of a tool's part goes through, before the physics step that brings the part to a pose.
    fn cut(&mut self, _: &mut PhysicsWorld, _: &Blade, _: &Pose) {}
    /// Does after a physics step, with the tool in `hand`, what the engine itself does not.
    fn mend(&mut self, _: &mut PhysicsWorld, _: &[RigidBodyHandle]) {}
    /// Has the next step read its particles anew, as after [`Substance::mend`]; a mark that no serialisation keeps.
    fn refresh(&mut self, _: &mut PhysicsWorld) {}
}

impl Matter {
    pub(super) fn substance(&self) -> &dyn Substance {
        match self {
            Self::Dough(dough) => dough,
            Self::Bodies(bodies) => bodies,
            Self::Liquid(liquid) => liquid,
        }
    }

    pub(super) fn substance_mut(&mut self) -> &mut dyn Substance {
        match self {
            Self::Dough(dough) => dough,
            Self::Bodies(bodies) => bodies,
            Self::Liquid(liquid) => liquid,
        }
    }
}
