//! A blow.
use super::patch::check;
use super::{Disturbance, Patch};
use crate::world::World;
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A blow along the table that a random part of the material gets: `v ← v + speed · direction · weight`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PushSpec {
    /// Range of the speed in the middle of that part \[m/s\].
    pub speed: [f64; 2],
    /// Width σ of that part \[m\].
    #[schemars(range(min = 0.0, max = 1.0))]
    pub radius: f64,
    /// Blows in a row, each a control step after the other.
    #[schemars(range(min = 1, max = 100))]
    pub blows: usize,
    /// Control steps until the next observation.
    #[schemars(range(min = 0, max = 1000))]
    pub rest: usize,
}

/// See [`PushSpec`].
#[derive(Clone, Debug)]
pub struct Push(PushSpec);

impl PushSpec {
    pub(crate) fn build(self) -> anyhow::Result<Push> {
        check("speed", self.speed, self.radius)?;
        Ok(Push(self))
    }
}

impl Disturbance for Push {
    fn disturb(&self, world: &mut World, rng: &mut ChaCha8Rng) {
        let PushSpec { speed, radius, blows, rest } = self.0;
        let patch = Patch::draw(world, radius, speed, rng);
        for _ in 0..blows {
            world.blow(&|place| patch.weight(place) * patch.amount * patch.direction);
            world.wait(1);
        }
        world.wait(rest);
    }
}
