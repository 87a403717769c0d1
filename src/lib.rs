//! Structured world models of deformable things.
#[macro_use]
mod family;
pub mod chooser;
pub mod config;
pub mod data;
pub mod graph;
pub mod metric;
pub mod model;
pub mod perception;
pub mod planner;
pub mod problem;
pub mod shape;
pub mod state;
pub mod sweep;
pub mod tool;
pub mod train;
pub mod watch;
pub mod world;
