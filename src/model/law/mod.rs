//! Laws: whatever accelerates a particle. Written or learned, they look the same, and a hybrid is a list of both.
use super::net::Wanted;
use crate::graph::Graph;
use crate::state::{Constants, Particles, ParticlesGrad, Pose, PoseGrad, Scene, ToolShape, Twist, Wall};
use glam::DVec3;
use std::path::Path;

pub mod bonds;
pub mod cohesion;
pub mod compliant;
pub mod contact;
pub mod floor;
pub mod formula;
mod frame;
pub mod gravity;
mod history;
mod learned;
mod learned_pair;
mod message;
mod neural_constants;
pub mod pair;
mod tangential;
pub mod tool;
mod touching;
pub mod viscosity;

pub use frame::FrameSpec;
pub use history::{History, Remember};
pub use learned::{Learned, LearnedSpec};
pub use learned_pair::{LearnedPair, LearnedPairSpec};
pub use message::Message;
pub use neural_constants::{NeuralConstants, NeuralConstantsSpec};

/// What a law may look at.
pub struct View<'a> {
    /// Particles now.
    pub particles: &'a Particles,
    /// Velocities one, two … control steps before \[m/s\], N rows each: at least as many as [`Law::memory`] asks for.
    pub past: &'a [Vec<DVec3>],
    /// Number of the body that each particle belongs to.
    pub body: &'a [u32],
    /// Walls around the table.
    pub walls: &'a [Wall],
    /// Their graph. For a law of [`Rate::Step`], what the model's policy drew. For a law of [`Rate::Substep`], only a half list
    /// of particle pairs, each once with receiver < sender, that holds at least all pairs within [`Law::reach`]; no nodes.
    pub graph: &'a Graph,
    /// Constants of the materials, as far as the scene tells them.
    pub constants: &'a Constants,
    /// Tool geometry.
    pub tool: &'a ToolShape,
    /// Pose of each part now; for a law of [`Rate::Step`], at the end of the control interval.
    pub poses: &'a [Pose],
    /// Velocity of each part over the control interval.
    pub twists: &'a [Twist],
    /// Duration of the control interval \[s\].
    pub interval: f64,
    /// What the law remembers of pairs, see [`Law::remembers`].
    pub history: &'a History,
}

/// `∂J/∂view`, and `∂J/∂weights` of the law.
pub struct ViewGrad<'a> {
    /// Particles' part.
    pub particles: ParticlesGrad,
    /// The past's part, as many as the model remembers.
    pub past: Vec<Vec<DVec3>>,
    /// Poses' part.
    pub poses: Vec<PoseGrad>,
    /// Twists' part.
    pub twists: Vec<Twist>,
    /// The part of what the law remembers of pairs, number by number.
    pub history: Vec<f64>,
    /// The law's own weights' part, flat; empty when nobody asks.
    pub weights: &'a mut [f32],
}

/// [`Law::accelerate_vjp`] at the view that it was traced at, with what it would otherwise compute again.
pub struct Traced<'a> {
    /// Memory that it holds.
    pub bytes: usize,
    /// The derivative.
    pub pull: TracedPull<'a>,
}

/// See [`Law::accelerate_vjp`].
pub type TracedPull<'a> = Box<dyn FnOnce(&View<'_>, &[DVec3], &mut ViewGrad<'_>) + 'a>;

/// How often a law is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rate {
    /// At every substep.
    Substep,
    /// Once a control interval, its acceleration held in between.
    Step,
}

/// A term of the acceleration \[m/s²\].
pub trait Law: Send + Sync {
    /// How often to ask.
    fn rate(&self) -> Rate {
        Rate::Substep
    }
    /// Whether this law can be asked about what starts from `scene`; called before any rollout.
    ///
    /// # Errors
    /// A sentence saying what does not suit the law.
    fn accepts(&self, _: &Scene) -> anyhow::Result<()> {
        Ok(())
    }
    /// Number of velocities before the present one that it looks at.
    fn memory(&self) -> usize {
        0
    }
    /// How it remembers pairs from substep to substep, where it does; only a law of [`Rate::Substep`] may.
    fn remembers(&self) -> Option<&dyn Remember> {
        None
    }
    /// Distance beyond which no particle acts on another \[m\].
    fn reach(&self) -> f64 {
        0.0
    }
    /// Longest substep that it bears \[s\]; infinite where nothing is stiff, or nothing is known.
    fn stable(&self) -> f64 {
        f64::INFINITY
    }
    /// Adds this law's acceleration of every particle to `out`.
    fn accelerate(&self, view: &View<'_>, out: &mut [DVec3]);
    /// Adds `∂J/∂view` to `grad`, from `∂J/∂acceleration`.
    fn accelerate_vjp(&self, view: &View<'_>, out: &[DVec3], grad: &mut ViewGrad<'_>);
    /// As [`Law::accelerate`], with the wanted derivatives there from a law of [`Rate::Step`] which would compute much of it again for them.
    fn trace(&self, view: &View<'_>, _: Wanted, out: &mut [DVec3]) -> Option<Traced<'_>> {
        self.accelerate(view, out);
        None
    }
    /// Names of the constants that it has derivatives by, as its config names them.
    fn constants(&self) -> Vec<&str> {
        Vec::new()
    }
    /// Adds `∂J/∂constants`, in the order of [`Law::constants`], to `constants`, from `∂J/∂acceleration`.
    fn constants_vjp(&self, view: &View<'_>, out: &[DVec3], constants: &mut [f64]) {
        let _ = (view, out);
        assert!(constants.is_empty(), "a law that names constants has no derivatives by them");
    }
    /// What two particles do to each other, where the law is nothing else and says it pair by pair.
    fn into_pair(self: Box<Self>) -> Option<Box<dyn pair::Pair>> {
        None
    }
    /// What it says in every meeting, where it is a sum of messages along normals and slidings.
    fn messages(&self, _: &View<'_>) -> Vec<Message> {
        Vec::new()
    }
    /// Adds `∂J/∂weights` to `weights` from `∂J/∂(N, T)` of every message, in the order of [`Law::messages`].
    fn messages_vjp(&self, view: &View<'_>, at: &[[f64; 2]], weights: &mut [f32]) {
        let _ = (view, weights);
        assert!(at.is_empty(), "a law that sends messages has no derivatives of them");
    }
    /// Trainable weights, flat.
    fn weights(&self) -> Vec<f32> {
        Vec::new()
    }
    /// Name of each weight matrix, as the file of weights has it, and how many weights it holds, in the order of
    /// [`Law::weights`].
    fn matrices(&self) -> Vec<(String, usize)> {
        Vec::new()
    }
    /// Replaces the weights.
    fn set_weights(&mut self, weights: &[f32]) {
        assert!(weights.is_empty(), "a law without weights was given some");
    }
    /// Writes the weights by name to a file that the law's config can name.
    ///
    /// # Errors
    /// When there are none, or the file cannot be written.
    fn save_weights(&self, path: &Path) -> anyhow::Result<()> {
        anyhow::bail!("{} cannot be written: the law has no weights", path.display())
    }
}

family! {
    /// Every law that a config can name.
    LawSpec builds Box<dyn Law> {
        Contact(contact::ContactSpec),
        Cohesion(cohesion::CohesionSpec),
        Bonds(bonds::BondsSpec),
        Viscosity(viscosity::ViscositySpec),
        Floor(floor::FloorSpec),
        Tool(tool::ToolSpec),
        Gravity(gravity::GravitySpec),
        Learned(learned::LearnedSpec),
        LearnedPair(learned_pair::LearnedPairSpec),
        NeuralConstants(neural_constants::NeuralConstantsSpec),
        Formula(formula::FormulaSpec),
    }
}

impl LawSpec {
    /// What its constants are addressed by: its `name`, or where it has none its `kind`.
    pub fn called(&self) -> String {
        let spec = serde_json::to_value(self).expect("specs are plain data");
        let called = spec["name"].as_str().or_else(|| spec["kind"].as_str());
        called.expect("a member of a family has a kind").to_owned()
    }
}
