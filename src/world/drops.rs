//! A start of two drops, one above the other.
use super::start::{Region, Start, between, check_turn};
use anyhow::ensure;
use glam::DVec3;
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Two balls in the air, the second above the first and a little aside.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DropsSpec {
    /// Range of each radius \[m\].
    pub radius: [f64; 2],
    /// Range of the free height between the table and the lower, and between the two \[m\].
    pub gap: [f64; 2],
    /// Range of the distance between their axes \[m\].
    pub aside: [f64; 2],
    /// Range of its turn about the vertical \[rad\].
    pub turn: [f64; 2],
}

impl DropsSpec {
    /// Checks the ranges.
    ///
    /// # Errors
    /// A sentence naming the key whose range is impossible.
    pub fn build(self) -> anyhow::Result<impl Start> {
        let ranges = [("radius", self.radius, 1e-4), ("gap", self.gap, 0.0), ("aside", self.aside, 0.0)];
        for (key, [low, high], least) in ranges {
            ensure!(
                least <= low && low <= high && high <= 1.0,
                "start.{key} = [{low}, {high}] must be [low, high] with {least} ≤ low ≤ high ≤ 1 m"
            );
        }
        check_turn(self.turn)?;
        Ok(self)
    }
}

impl Start for DropsSpec {
    fn draw(&self, rng: &mut ChaCha8Rng) -> Region {
        let [lower, upper] = [self.radius, self.radius].map(|range| between(range, rng));
        let [raised, gap] = [self.gap, self.gap].map(|range| between(range, rng));
        let aside = between(self.aside, rng);
        let middles = [DVec3::new(-aside / 2.0, 0.0, lower), DVec3::new(aside / 2.0, 0.0, 2.0 * lower + gap + upper)];
        let wide = lower.max(upper);
        let top = 2.0 * (lower + upper) + gap;
        let bounds = (DVec3::new(-aside / 2.0 - wide, -wide, 0.0), DVec3::new(aside / 2.0 + wide, wide, top));
        let contains = move |p: DVec3| p.distance(middles[0]) <= lower || p.distance(middles[1]) <= upper;
        Region { bounds, contains: Box::new(contains), turn: between(self.turn, rng), raised }
    }
}
