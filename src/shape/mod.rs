//! Goal shapes and point clouds: letters and primitives, clouds and meshes read from files, and even sampling.
//!
//! A [`Shape`] stands on the table z = 0 in metres; what [`ShapeSpec`] builds is centred at x = y = 0.
use crate::shape::poisson::dense_enough;
use glam::DVec3;
use rand_chacha::ChaCha8Rng;

mod cloud;
mod extruded;
mod farthest;
mod fill;
mod letter;
mod npy;
mod ply;
mod poisson;
mod primitive;
mod read;
mod spacing;
mod stl;

pub use cloud::CloudSpec;
pub use extruded::{Extruded, Outline};
pub use farthest::{farthest_points, farthest_points_from};
pub use fill::{FillSpec, Filled};
pub(crate) use letter::hack;
pub use letter::{Glyph, LetterSpec, letter};
pub use poisson::poisson_disk;
pub use primitive::{CuboidSpec, DiscSpec, Ellipse, Ellipsoid, EllipsoidSpec, Rectangle, Ring, RingSpec};
pub use read::{parse_points, read_mesh, read_points};
pub use spacing::spacing;

/// A set of points in space with a volume, standing on the table z = 0.
pub trait Shape: Send + Sync {
    /// Whether `point` \[m\] belongs to the shape.
    fn contains(&self, point: DVec3) -> bool;
    /// The lowest and highest corner of an axis-aligned box around the shape \[m\].
    fn bounds(&self) -> (DVec3, DVec3);
    /// Volume \[m³\], positive.
    fn volume(&self) -> f64;

    /// Exactly `count` points spread evenly over the volume: a Poisson-disk sample about four times as dense, thinned by
    /// [`farthest_points`].
    fn points(&self, count: usize, rng: &mut ChaCha8Rng) -> Vec<DVec3> {
        let candidates = dense_enough(self, count, rng);
        farthest_points(&candidates, count).into_iter().map(|i| candidates[i]).collect()
    }
}

family! {
    /// The shapes that a config can name.
    ShapeSpec builds Box<dyn Shape> {
        Letter(LetterSpec),
        Cuboid(CuboidSpec),
        Disc(DiscSpec),
        Ring(RingSpec),
        Ellipsoid(EllipsoidSpec),
        Cloud(CloudSpec),
    }
}
