//! A random part of the material and a random way to move it.
use crate::tool::Workpiece;
use crate::world::World;
use anyhow::ensure;
use glam::{DVec2, DVec3};
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

/// The weight `exp(−|x − c|² / 2σ²)` in the table plane around a place c of the material, and a horizontal direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// c \[m\].
    pub centre: DVec2,
    /// σ \[m\].
    pub radius: f64,
    /// Unit vector.
    pub direction: DVec3,
    /// How much to move it, in the unit of the range that it was drawn from.
    pub amount: f64,
}

impl Patch {
    /// Draws a place on the ellipse halfway between the middle and the side of what the world holds, a direction, and an amount
    /// between the two numbers of `range`.
    pub fn draw(world: &World, radius: f64, [low, high]: [f64; 2], rng: &mut ChaCha8Rng) -> Self {
        let [at, toward] = [0; 2].map(|_| DVec2::from_angle(TAU * rng.random::<f64>()));
        let amount = low + (high - low) * rng.random::<f64>();
        let piece = Workpiece::around(&world.particles());
        let centre = piece.centre.truncate() + 0.5 * at * piece.extent.truncate();
        Self { centre, radius, direction: toward.extend(0.0), amount }
    }

    /// The weight at `place` \[m\].
    pub fn weight(&self, place: DVec3) -> f64 {
        (-place.truncate().distance_squared(self.centre) / (2.0 * self.radius * self.radius)).exp()
    }
}

/// Refuses a patch that cannot be.
///
/// # Errors
/// A sentence naming the key, `key` being that of the range.
pub(super) fn check(key: &str, [low, high]: [f64; 2], radius: f64) -> anyhow::Result<()> {
    ensure!(
        0.0 <= low && low <= high && high.is_finite(),
        "disturbance.{key} = [{low}, {high}] must be [low, high] with 0 ≤ low ≤ high"
    );
    ensure!(radius > 0.0 && radius.is_finite(), "disturbance.radius is {radius} m; it must be positive");
    Ok(())
}
