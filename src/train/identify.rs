//! Identification: the constants of written laws that fit the data best.
use super::constants::value;
use super::fitting::{Build, Fitting, mean_cost};
use super::identification::{BESIDE, Constant, Errors, Identification};
use super::identify_spec::IdentifySpec;
use super::journal::Journal;
use super::matched::{Matched, displacement_scale};
use super::search::{Cone, Found, Search, Start, Tried, place};
use super::split::Split;
use super::window::Window;
use super::windows::Windows;
use crate::config::write_whole;
use crate::data::Episode;
use crate::model::Cost;
use crate::state::stream;
use crate::watch::Watch;
use anyhow::Context;
use indexmap::IndexMap;
use rand::Rng;
use serde::Serialize;
use serde_json::{Value, json};
use std::path::Path;
use std::time::Instant;

/// Fits constants to data.
pub struct Identifier {
    pub(super) spec: IdentifySpec,
    pub(super) cones: Vec<Cone>,
    pub(super) search: Box<dyn Search>,
}

/// Random starts that are drawn until one lies in all cones; where none does, the model's own is taken again.
const DRAWS: usize = 1000;

/// A line of `metrics.jsonl`.
#[derive(Serialize)]
struct Line {
    /// Number of the round.
    step: u64,
    /// Best error so far \[m\].
    error: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    sigma: Option<f64>,
    evaluations: usize,
    constants: IndexMap<String, f64>,
    seconds: f64,
}

impl Identifier {
    /// Finds the constants in `model` (a config as JSON) with the smallest [`Matched`] error on fixed windows of the
    /// training episodes in which something moves, starting from those it has; returns the config with them.
    ///
    /// Writes `costs.bin` (what has been tried, so that a stopped search goes on), `metrics.jsonl` and, at the end,
    /// `identify.json` into `folder`. A learned law in the model takes part as it is.
    ///
    /// # Errors
    /// When the data cannot be used, a path is unknown, the search needs a derivative that the model has not, a file cannot be
    /// written, or `watch` asks to stop (then everything is saved first).
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
        let forbidden = self.cones.iter().position(|cone| !cone.holds(&before));
        if let Some(cone) = forbidden.map(|k| &spec.cones[k]) {
            let (within, of) = (&cone.within, cone.of.join(", "));
            anyhow::bail!(
                "the model's own constants lie outside the cone of {of} within `{within}`; start from others"
            );
        }
        let (constants, cones) = (&spec.constants, &self.cones[..]);
        let fitting = Fitting { model, build, constants, cones, windows: &windows, scale };
        if self.search.differentiates() {
            fitting.places(&*first)?;
        }

        std::fs::create_dir_all(folder).with_context(|| format!("cannot create {}", folder.display()))?;
        let identity = json!([spec, model, scale, windows.len()]).to_string();
        let tried = Tried::new(&fitting, folder, &identity)?;
        let start: Vec<f64> =
            before.iter().zip(spec.constants.values()).map(|(c, bounds)| place(*c, *bounds)).collect();
        let clock = Instant::now();
        let found = self.search(start, &tried, &fitting, folder, watch)?;
        let seconds = clock.elapsed().as_secs_f64();

        let after = fitting.constants(&found.point);
        let fitted = fitting.with(&after)?;
        let last = build(&fitted)?;
        let beside = |k: usize| {
            BESIDE.map(|factor| {
                let mut changed = after.clone();
                changed[k] *= factor;
                rms(fitting.error(&changed), scale)
            })
        };
        let rows = spec.constants.iter().zip(before).zip(&after).enumerate();
        let constants = rows.map(|(k, (((path, [low, high]), before), after))| {
            (path.clone(), Constant { before, after: *after, low: *low, high: *high, beside: beside(k) })
        });
        let constants = constants.collect();
        let compare = |windows: &[Window<'_>]| Errors {
            before: rms(mean_cost(&*first, windows, scale), scale),
            after: rms(mean_cost(&*last, windows, scale), scale),
            still: still(windows, scale),
        };
        let (train, held_out) = (compare(&windows), (!held_out.is_empty()).then(|| compare(&held_out)));
        let identification = Identification { constants, train, held_out, evaluations: found.evaluations, seconds };
        write_whole(&folder.join("identify.json"), &serde_json::to_vec_pretty(&identification)?)?;
        Ok((fitted, identification))
    }

    /// Searches from every start, the first where the model's config is and all others at random, with equal shares of the evaluations.
    fn search(
        &self,
        start: Vec<f64>,
        tried: &Tried<'_>,
        fitting: &Fitting<'_>,
        folder: &Path,
        watch: &Watch,
    ) -> anyhow::Result<Found> {
        let spec = &self.spec;
        let mut journal = Journal::open(folder, 0)?;
        let bar = watch.stage("identify", spec.evaluations as u64);
        let mut round = 0;
        let mut each = |sigma: Option<f64>| {
            round += 1;
            tried.save()?;
            let best = tried.best()?;
            let error = fitting.scale * best.cost.sqrt();
            let constants = spec.constants.keys().cloned().zip(fitting.constants(&best.point)).collect();
            let (evaluations, seconds) = (best.evaluations, bar.elapsed().as_secs_f64());
            journal.line(&Line { step: round, error, sigma, evaluations, constants, seconds })?;
            bar.set_position(best.evaluations as u64);
            bar.set_message(format!("error {:.3} mm", 1e3 * error));
            watch
                .go_on(|| format!("identification stopped after round {round}; the same command goes on from there"))?;
            Ok(())
        };
        for k in 0..spec.starts {
            let mut rng = stream(spec.seed, &[u64::from_le_bytes(*b"starts  "), k as u64]);
            let point = match k {
                0 => start.clone(),
                _ => {
                    let mut draw = || start.iter().map(|_| rng.random()).collect::<Vec<f64>>();
                    // The model's own constants lie in all cones, so that there is some room.
                    std::iter::repeat_with(&mut draw).take(DRAWS).find(|p| tried.holds(p)).unwrap_or(start.clone())
                }
            };
            let evaluations = (spec.evaluations - tried.spent().min(spec.evaluations)) / (spec.starts - k);
            let seed = spec.seed.wrapping_add(k as u64);
            self.search.search(&Start { point, sigma: spec.sigma, seed, evaluations }, tried, &mut each)?;
        }
        if tried.spent() == 0 {
            // Too few evaluations for a single derivative: the model stays as it is.
            tried.cost(&start);
        }
        bar.finish();
        tried.best()
    }

    fn windows<'a>(&self, episodes: &'a [Episode], split: &'a Split) -> anyhow::Result<Vec<Window<'a>>> {
        let all = Windows::new(episodes, &split.tools, self.spec.horizon, self.spec.motion)?;
        Ok(all.spread_moving(self.spec.windows))
    }
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
