//! Teaching a network of two clouds of points: one loop for what proposes actions and what chooses tools.
mod clouds;
mod spec;
mod teach;

pub use clouds::Clouds;
pub use spec::PointNetSpec;

pub(super) use teach::{Example, Lesson, said, taught};
