//! What happens to the material between actions that no model is told of.
use crate::world::World;
use rand_chacha::ChaCha8Rng;

mod displace;
mod patch;
mod push;

pub use displace::{Displace, DisplaceSpec};
pub use patch::Patch;
pub use push::{Push, PushSpec};

/// Something from outside that changes the world while nobody acts.
pub trait Disturbance: Send + Sync {
    /// Changes `world`, the tool in hand laid aside, and lets it come to rest. It takes equally many numbers from `rng` whatever
    /// the world: streams alike disturb every model and way of control alike.
    fn disturb(&self, world: &mut World, rng: &mut ChaCha8Rng);
}

family! {
    /// Every disturbance that a config can name.
    DisturbanceSpec builds Box<dyn Disturbance> { Push(PushSpec), Displace(DisplaceSpec) }
}
