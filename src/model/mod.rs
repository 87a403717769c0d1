//! World models: how particles move when a tool moves.
//!
//! A model's author implements [`Dynamics`] and, where it has derivatives, [`Adjoint`]; everyone else holds a [`WorldModel`].
mod dynamics;
pub mod law;
pub mod net;
mod world_model;

pub use dynamics::{Adjoint, Dynamics};
pub use world_model::{Cost, Gradient, WorldModel};
