//! The shapes that dough starts in, drawn by seed.
use super::drops::DropsSpec;
use anyhow::ensure;
use glam::DVec3;
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A drawn start: a solid standing on z = 0 around the origin, turned about the vertical.
pub struct Region {
    /// Corners of its bounding box, before turning \[m\].
    pub bounds: (DVec3, DVec3),
    /// Whether a point is inside, before turning.
    pub contains: Box<dyn Fn(DVec3) -> bool>,
    /// Turn about z \[rad\].
    pub turn: f64,
    /// Height above the table at which its lowest point begins \[m\].
    pub raised: f64,
}

/// A family of starts.
pub trait Start {
    /// One of them.
    fn draw(&self, rng: &mut ChaCha8Rng) -> Region;
}

family! {
    /// The kinds of starts.
    StartSpec builds Box<dyn Start> { Block(BlockSpec), Ellipsoid(EllipsoidSpec), Drops(DropsSpec) }
}

/// A rectangular block.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BlockSpec {
    /// Range of its size along x \[m\].
    pub x: [f64; 2],
    /// Range of its size along y \[m\].
    pub y: [f64; 2],
    /// Range of its height \[m\].
    pub z: [f64; 2],
    /// Range of its turn about the vertical \[rad\].
    pub turn: [f64; 2],
}

/// An ellipsoid, its lower half replaced by the cylinder under its equator so that it stands.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EllipsoidSpec {
    /// Range of its size along x \[m\].
    pub x: [f64; 2],
    /// Range of its size along y \[m\].
    pub y: [f64; 2],
    /// Range of its height \[m\].
    pub z: [f64; 2],
    /// Range of its turn about the vertical \[rad\].
    pub turn: [f64; 2],
}

impl BlockSpec {
    /// Checks the ranges.
    ///
    /// # Errors
    /// A sentence naming the key whose range is impossible.
    pub fn build(self) -> anyhow::Result<impl Start> {
        check([("x", self.x), ("y", self.y), ("z", self.z)], self.turn)?;
        Ok(self)
    }
}

impl EllipsoidSpec {
    /// Checks the ranges.
    ///
    /// # Errors
    /// A sentence naming the key whose range is impossible.
    pub fn build(self) -> anyhow::Result<impl Start> {
        check([("x", self.x), ("y", self.y), ("z", self.z)], self.turn)?;
        Ok(self)
    }
}

impl Start for BlockSpec {
    fn draw(&self, rng: &mut ChaCha8Rng) -> Region {
        let bounds = standing(&[self.x, self.y, self.z], rng);
        Region { bounds, contains: Box::new(|_| true), turn: between(self.turn, rng), raised: 0.0 }
    }
}

impl Start for EllipsoidSpec {
    fn draw(&self, rng: &mut ChaCha8Rng) -> Region {
        let bounds = standing(&[self.x, self.y, self.z], rng);
        let (half, height) = (bounds.1.truncate(), bounds.1.z);
        let contains = move |p: DVec3| {
            let rise = (2.0 * p.z / height - 1.0).max(0.0);
            (p.truncate() / half).length_squared() + rise * rise <= 1.0
        };
        Region { bounds, contains: Box::new(contains), turn: between(self.turn, rng), raised: 0.0 }
    }
}

fn check(sizes: [(&str, [f64; 2]); 3], turn: [f64; 2]) -> anyhow::Result<()> {
    for (key, [low, high]) in sizes {
        ensure!(
            0.0 < low && low <= high && high <= 1.0,
            "start.{key} = [{low}, {high}] must be [low, high] with 0 < low ≤ high ≤ 1 m"
        );
    }
    check_turn(turn)
}

/// Checks a range of turns.
///
/// # Errors
/// When it is none.
pub(super) fn check_turn([low, high]: [f64; 2]) -> anyhow::Result<()> {
    ensure!(low <= high && (high - low).is_finite(), "start.turn = [{low}, {high}] must be [low, high]");
    Ok(())
}

fn standing(sizes: &[[f64; 2]; 3], rng: &mut ChaCha8Rng) -> (DVec3, DVec3) {
    let size = DVec3::from_array(sizes.map(|range| between(range, rng)));
    let half = size / 2.0;
    (-half.with_z(0.0), half.with_z(size.z))
}

pub(super) fn between([low, high]: [f64; 2], rng: &mut ChaCha8Rng) -> f64 {
    low + (high - low) * rng.random::<f64>()
}
