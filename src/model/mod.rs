//! World models: how particles move when a tool moves.
//!
//! A model's author implements [`Dynamics`] and, where it has derivatives, [`Adjoint`]; everyone else holds a [`WorldModel`].
mod backward;
mod checkpoints;
pub mod correction;
mod cotangent;
mod dynamics;
pub mod formula;
pub mod height_map;
mod latent;
pub mod law;
mod linear;
pub mod mpm;
pub mod net;
mod oracle;
pub mod particles;
mod placed;
pub mod still;
mod unet;
mod world_model;

pub use checkpoints::Checkpoints;
pub use dynamics::{Adjoint, Dynamics, Traced, TracedPull};
pub use latent::{CloudSpec, LatentSpec, TopSpec, ViewSpec};
pub use linear::LinearSpec;
pub use oracle::{Oracle, OracleSpec};
pub use unet::UNetSpec;
pub use world_model::{ConstantGradient, Cost, Gradient, WorldModel};

family! {
    /// Every model that a config can name.
    ModelSpec builds Box<dyn WorldModel> {
        Particles(particles::ParticlesSpec),
        Latent(latent::LatentSpec),
        Linear(linear::LinearSpec),
        Unet(unet::UNetSpec),
        Mpm(mpm::MpmSpec),
        Still(still::StillSpec),
        Oracle(oracle::OracleSpec),
    }
}
