//! The nouns every other module speaks: particles, rigid poses, tools in motion, rollouts, and their gradients.
//!
//! SI units; z points up; the table is the plane z = 0.
mod action;
mod assembly;
mod blade;
mod closure;
mod mesh;
mod order;
mod particles;
mod pose;
mod rotation;
mod scene;
mod solid;
mod stream;
mod surface;
mod triangle;
mod wall;

pub use action::ActionSpace;
pub use assembly::Placed;
pub use blade::Blade;
pub use closure::Closure;
pub use mesh::TriangleMesh;
pub use order::Order;
pub use particles::{Particles, ParticlesGrad, Rollout};
pub use pose::{Pose, PoseGrad, Twist};
pub use rotation::{rotation_between, rotation_between_vjp};
pub use scene::{Constants, Control, ControlGrad, MEMORY, Scene, SceneGrad, Snapshot};
pub use solid::{Part, Projection, Solid, SurfacePoint, ToolShape};
pub use stream::stream;
pub use wall::Wall;
