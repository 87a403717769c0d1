//! Data that a model with known constants makes, recorded with noise.
use pliant::data::Episode;
use pliant::model::WorldModel;
use pliant::state::{Particles, stream};
use pliant::train::{Identification, Split, value};
use rand_distr::{Distribution, StandardNormal};
use serde_json::Value;

/// Constants that decide how the model's dough flows.
pub(crate) const CONSTANTS: [&str; 5] = [
    "laws.contact.stiffness",
    "laws.cohesion.strength",
    "laws.viscosity.rate",
    "laws.tool.friction",
    "laws.floor.friction",
];

/// Recordings replaced by what a model does under the same tool motions.
pub(crate) struct Truth(Split);

impl Truth {
    /// From where every episode of `recorded` starts.
    pub(crate) fn new(model: &dyn WorldModel, recorded: &Split) -> Self {
        let redone = |episode: &Episode| {
            let scene = episode.scene(0, &recorded.tools[&episode.tool]);
            Episode { states: model.rollout(&scene, &episode.controls), ..episode.clone() }
        };
        let all = |episodes: &[Episode]| episodes.iter().map(redone).collect();
        Self(Split { train: all(&recorded.train), held_out: all(&recorded.held_out), tools: recorded.tools.clone() })
    }

    /// With normal noise of deviation `noise` \[m\] on every coordinate, and on velocities that of their backward differences.
    pub(crate) fn recorded(&self, noise: f64, seed: u64) -> Split {
        let Self(Split { train, held_out, tools }) = self;
        let all = |episodes: &[Episode], part: u64| {
            episodes.iter().zip(0..).map(|(e, k)| noisy(e, noise, &[seed, part, k])).collect()
        };
        Split { train: all(train, 0), held_out: all(held_out, 1), tools: tools.clone() }
    }
}

fn noisy(episode: &Episode, noise: f64, words: &[u64]) -> Episode {
    let mut episode = episode.clone();
    if noise == 0.0 {
        return episode;
    }
    let mut rng = stream(2, &[&[u64::from_le_bytes(*b"recovery")], words].concat());
    let mut shift = |_| {
        glam::DVec3::from_array(std::array::from_fn(|_| {
            let n: f64 = StandardNormal.sample(&mut rng);
            noise * n
        }))
    };
    let count = episode.states[0].len();
    let mut last: Vec<glam::DVec3> = (0..count).map(&mut shift).collect();
    for Particles { positions, velocities } in &mut episode.states {
        let now: Vec<glam::DVec3> = (0..count).map(&mut shift).collect();
        for (i, (x, v)) in positions.iter_mut().zip(velocities).enumerate() {
            *x += now[i];
            *v += (now[i] - last[i]) / episode.interval;
        }
        last = now;
    }
    episode
}

/// The relative error of the constant that is furthest off.
pub(crate) fn worst(found: &Identification, truth: &Value) -> anyhow::Result<f64> {
    let off =
        |(path, constant): (&String, &pliant::train::Constant)| Ok((constant.after / value(truth, path)? - 1.0).abs());
    found.constants.iter().map(off).try_fold(0.0, |worst, off: anyhow::Result<f64>| Ok(f64::max(worst, off?)))
}
