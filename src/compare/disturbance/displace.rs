//! A part of the material is taken elsewhere.
use super::patch::check;
use super::{Disturbance, Patch};
use crate::world::World;
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A random part of the material is drawn along the table: `x ← x + distance · direction · weight`, in equal shares a control step
/// apart, so that dough flows along.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DisplaceSpec {
    /// Range of the distance in the middle of that part \[m\].
    pub distance: [f64; 2],
    /// Width σ of that part \[m\].
    #[schemars(range(min = 0.0, max = 1.0))]
    pub radius: f64,
    /// Number of shares.
    #[schemars(range(min = 1, max = 100))]
    pub shares: usize,
    /// Control steps until the next observation.
    #[schemars(range(min = 0, max = 1000))]
    pub rest: usize,
}

/// See [`DisplaceSpec`].
#[derive(Clone, Debug)]
pub struct Displace(DisplaceSpec);

impl DisplaceSpec {
    pub(crate) fn build(self) -> anyhow::Result<Displace> {
        check("distance", self.distance, self.radius)?;
        anyhow::ensure!(self.shares > 0, "disturbance.shares is 0; nothing would be displaced");
        Ok(Displace(self))
    }
}

impl Disturbance for Displace {
    fn disturb(&self, world: &mut World, rng: &mut ChaCha8Rng) {
        let DisplaceSpec { distance, radius, shares, rest } = self.0;
        let mut patch = Patch::draw(world, radius, distance, rng);
        let share = patch.amount / shares as f64 * patch.direction;
        for _ in 0..shares {
            world.shift(&|place| patch.weight(place) * share);
            world.wait(1);
            patch.centre += share.truncate();
        }
        world.wait(rest);
    }
}
