//! World models: how particles move when a tool moves.
//!
//! A model's author implements [`Dynamics`] and, where it has derivatives, [`Adjoint`]; everyone else holds a [`WorldModel`].
mod backward;
mod dynamics;
pub mod formula;
pub mod law;
pub mod net;
mod oracle;
pub mod particles;
pub mod still;
mod world_model;

pub use dynamics::{Adjoint, Dynamics};
pub use oracle::{Oracle, OracleSpec};
pub use world_model::{ConstantGradient, Cost, Gradient, WorldModel};

family! {
    /// Every model that a config can name.
    ModelSpec builds Box<dyn WorldModel> {
        Particles(particles::ParticlesSpec),
        Still(still::StillSpec),
        Oracle(oracle::OracleSpec),
    }
}
