//! Identification: the constants of written laws that fit the data best.
use super::constants::{replace, value};
use super::identify_spec::IdentifySpec;
use super::journal::Journal;
use super::matched::{Matched, displacement_scale};
use super::search::Search;
use super::split::Split;
use super::window::Window;
use super::windows::Windows;
use crate::config::write_whole;
use crate::data::Episode;
use crate::model::{Cost, WorldModel};
use crate::watch::Watch;
use anyhow::Context;
use indexmap::IndexMap;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::path::Path;

/// Fits constants to data.
#[derive(Clone, Debug)]
pub struct Identifier {
    pub(super) spec: IdentifySpec,
}

/// What a finished identification reports, also in `identify.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Identification {
    /// By path.
    pub constants: IndexMap<String, Constant>,
    /// Error on the windows that were fitted to.
    pub train: Errors,
    /// Error on windows of episodes that were not, taken in the same way.
    pub held_out: Option<Errors>,
    /// Sets of constants that were tried.
    pub evaluations: usize,
}

/// A constant before and after, and its bounds, in its own unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Constant {
    /// In the model's config.
    pub before: f64,
    /// The best found.
    pub after: f64,
    /// Lower bound.
    pub low: f64,
    /// Upper bound.
    pub high: f64,
}

/// Root mean square position error over windows, their steps and particles \[m\].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// With the constants of the model's config; `None` when not finite.
    pub before: Option<f64>,
    /// With the constants found; `None` when not finite.
    pub after: Option<f64>,
    /// If nothing ever moved.
    pub still: f64,
}

/// A line of `metrics.jsonl`.
#[derive(Serialize)]
struct Line {
    /// Number of the generation.
    step: u64,
    /// Best error so far \[m\].
    error: f64,
    sigma: f64,
    evaluations: usize,
    constants: IndexMap<String, f64>,
    seconds: f64,
}

/// Turns a model's config into a model.
pub(super) type Build<'a> = &'a (dyn Fn(&Value) -> anyhow::Result<Box<dyn WorldModel>> + Sync);

/// A constant's place between its bounds on a logarithmic scale, `u = ln(c/low) / ln(high/low)`.
fn place(constant: f64, [low, high]: [f64; 2]) -> f64 {
    (constant.clamp(low, high) / low).ln() / (high / low).ln()
}

/// The constant at place `u`.
fn at(u: f64, [low, high]: [f64; 2]) -> f64 {
    (low * (high / low).powf(u)).clamp(low, high)
}

impl Identifier {
    /// Finds the constants in `model` (a config as JSON) with the smallest [`Matched`] error on fixed windows of the
    /// training episodes in which something moves, starting from those it has; returns the config with them.
    ///
    /// Writes `costs.bin` (what has been tried, so that a stopped search goes on), `metrics.jsonl` and, at the end,
    /// `identify.json` into `folder`. A learned law in the model takes part as it is.
    ///
    /// # Errors
    /// When the data cannot be used, a path is unknown, a file cannot be written, or `watch` asks to stop (then
    /// everything is saved first).
    pub fn identify(
        &self,
        model: &Value,
        build: Build<'_>,
        split: &Split,
        folder: &Path,
        watch: &Watch,
    ) -> anyhow::Result<(Value, Identification)> {
        let spec = &self.spec;
        let scale = displacement_scale(&split.train, spec.motion)?;
        let windows = self.windows(&split.train, split)?;
        let held_out = self.windows(&split.held_out, split)?;
        let before: Vec<f64> = spec.constants.keys().map(|path| value(model, path)).collect::<anyhow::Result<_>>()?;
        let first = build(model)?;
        let mut scenes = windows.iter().chain(&held_out);
        scenes.try_for_each(|w| first.accepts(&w.scene)).context("the model cannot start from the data")?;
        let with = |point: &[f64]| {
            let bounds = spec.constants.iter().zip(point);
            replace(model, bounds.map(|((path, bounds), u)| (path.as_str(), at(*u, *bounds))))
        };
        let cost = |point: &[f64]| {
            // A set of constants that the model refuses is as bad as one that makes it diverge.
            with(point).and_then(|spec| build(&spec)).map_or(f64::NAN, |model| mean_cost(&*model, &windows, scale))
        };

        std::fs::create_dir_all(folder).with_context(|| format!("cannot create {}", folder.display()))?;
        let identity = json!([spec, model, scale, windows.len()]).to_string();
        let mut journal = Journal::open(folder, 0)?;
        let bar = watch.stage("identify", spec.evaluations as u64);
        let search = Search {
            start: before.iter().zip(spec.constants.values()).map(|(c, bounds)| place(*c, *bounds)).collect(),
            sigma: spec.sigma,
            seed: spec.seed,
            evaluations: spec.evaluations,
            memory: &folder.join("costs.bin"),
            identity: &identity,
        };
        let found = search.minimise(cost, |generation, best, sigma| {
            let error = scale * best.cost.sqrt();
            journal.line(&Line {
                step: generation,
                error,
                sigma,
                evaluations: best.evaluations,
                constants: self.constants(&best.point),
                seconds: bar.elapsed().as_secs_f64(),
            })?;
            bar.set_position(best.evaluations as u64);
            bar.set_message(format!("error {:.3} mm", 1e3 * error));
            watch.go_on(|| {
                format!("identification stopped after generation {generation}; the same command goes on from there")
            })?;
            Ok(())
        })?;
        bar.finish();

        let fitted = with(&found.point)?;
        let last = build(&fitted)?;
        let rows = spec.constants.iter().zip(before).zip(self.constants(&found.point).into_values());
        let constants = rows.map(|(((path, [low, high]), before), after)| {
            (path.clone(), Constant { before, after, low: *low, high: *high })
        });
        let compare = |windows: &[Window<'_>]| Errors {
            before: rms(mean_cost(&*first, windows, scale), scale),
            after: rms(mean_cost(&*last, windows, scale), scale),
            still: still(windows, scale),
        };
        let identification = Identification {
            constants: constants.collect(),
            train: compare(&windows),
            held_out: (!held_out.is_empty()).then(|| compare(&held_out)),
            evaluations: found.evaluations,
        };
        write_whole(&folder.join("identify.json"), &serde_json::to_vec_pretty(&identification)?)?;
        Ok((fitted, identification))
    }

    fn windows<'a>(&self, episodes: &'a [Episode], split: &'a Split) -> anyhow::Result<Vec<Window<'a>>> {
        let all = Windows::new(episodes, &split.tools, self.spec.horizon, self.spec.motion)?;
        Ok(all.spread_moving(self.spec.windows))
    }

    fn constants(&self, point: &[f64]) -> IndexMap<String, f64> {
        let places = self.spec.constants.iter().zip(point);
        places.map(|((path, bounds), u)| (path.clone(), at(*u, *bounds))).collect()
    }
}

/// Mean [`Matched`] error over windows, summed in their order.
fn mean_cost(model: &dyn WorldModel, windows: &[Window<'_>], scale: f64) -> f64 {
    let costs: Vec<f64> = windows
        .par_iter()
        .map(|w| {
            let rollout = model.rollout(&w.scene, &w.controls);
            let finite = rollout.iter().all(|x| x.is_finite());
            if finite { Matched { targets: &w.targets, scale }.total(&rollout) } else { f64::INFINITY }
        })
        .collect();
    costs.iter().sum::<f64>() / costs.len() as f64
}

fn still(windows: &[Window<'_>], scale: f64) -> f64 {
    let stay = |w: &Window<'_>| {
        let cost = Matched { targets: &w.targets, scale };
        cost.total(&vec![w.scene.particles.clone(); w.targets.len() + 1])
    };
    scale * (windows.iter().map(stay).sum::<f64>() / windows.len() as f64).sqrt()
}

fn rms(cost: f64, scale: f64) -> Option<f64> {
    cost.is_finite().then(|| scale * cost.sqrt())
}
