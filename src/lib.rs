//! Pliant: structured world models of deformable things.
//!
//! A scene is N particles `x_t` on a table and a rigid tool; `u_t` is the pose of each tool part at the end of a control interval. A
//! world model predicts
//!
//! ```text
//! x_{t+1} = f(x_t, u_t)
//! ```
//!
//! and a robot that knows f plans: a tool's motion primitive turns a few numbers θ in a box Θ into u_0 … u_{H−1}, and
//!
//! ```text
//! min over tools, min over θ ∈ Θ of  J(θ) = ℓ(x_H, goal)
//! ```
//!
//! is searched through f, executed in the world, observed, and searched again. Pliant asks which f to plan with — written by hand,
//! learned, or both — with everything else kept identical, and answers with a table.
//!
//! # The house
//!
//! Each module imports only from those above it (`tests/architecture.rs` checks this).
//!
//! | module | what it holds |
//! |---|---|
//! | [`watch`] | progress of long stages, and the wish to stop them |
//! | [`config`] | TOML with `extends`, named parts, Hydra's overrides, errors that point at the line |
//! | [`state`] | the nouns: particles, poses, solids, scenes, controls, rollouts, and their gradients |
//! | [`shape`] | goal shapes, point clouds and meshes: letters, primitives, readers, sampling |
//! | [`tool`] | motion primitives: θ in a box becomes a path of rigid parts |
//! | [`world`] | the ground truth in Rapier: dough, grains, rigid pieces, tools, snapshots |
//! | [`perception`] | observations → particles |
//! | [`graph`] | typed edges between particles, tool, walls and floor; roots over the particles, bonds between them |
//! | [`model`] | world models: laws, written or learned, and their exact gradients |
//! | [`data`] | episodes on disk |
//! | [`metric`] | distances between shapes, what they share, and the costs made of them |
//! | [`train`] | one loop for everything learned, identification for everything written |
//! | [`planner`] | searches over a box; they see a cost, never a particle |
//! | [`problem`] | model, tool, scene and goal as that cost, with a counted budget |
//! | [`chooser`] | which tool |
//! | [`compare`] | the same planner, budget and random numbers for every model |
//! | [`table`] | rows → terminal, Markdown, LaTeX, HTML |
//! | [`view`] | an episode and its prediction as a page that plays |
//! | [`sweep`] | many comparisons, resumable |
//!
//! # A taste
//!
//! Press a block of dough with the simulator itself as the model: it predicts exactly what then happens.
//!
//! ```
//! use pliant::{compare::CompareSpec, config, model::WorldModel, tool::Workpiece, world::World};
//!
//! # fn main() -> anyhow::Result<()> {
//! let spec = config::load::<CompareSpec>("configs/compare/quickstart.toml".as_ref(), &[])?.spec;
//! let mut world = World::new(&spec.dataset.scene, 0)?;
//! let press = spec.dataset.tool["press_square"].clone().build()?;
//! let piece = Workpiece::around(&world.particles());
//! let theta = press.space(&piece).at(&[0.5, 0.5, 0.2, 0.5]);
//! let motion = press.motion(&theta, &piece, spec.dataset.steps);
//!
//! let oracle = spec.model["oracle"].dynamics.clone().build()?;
//! let predicted = oracle.rollout(&world.scene(press.shape(), &motion.start), &motion.controls);
//! let happened = world.execute(press.shape(), &motion);
//! assert_eq!(predicted, happened);
//! assert!(Workpiece::around(&happened[15]).extent.z < 0.9 * piece.extent.z);
//! # Ok(())
//! # }
//! ```
#[macro_use]
mod family;
pub mod chooser;
pub mod compare;
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
pub mod table;
pub mod tool;
pub mod train;
pub mod view;
pub mod watch;
pub mod world;
