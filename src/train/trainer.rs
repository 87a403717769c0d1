//! One training loop for everything learned, a pure network and the learned law of a hybrid alike.
use super::adam::clip;
use super::checkpoint::{Best, Checkpoint, load, save};
use super::evaluate::{Evaluation, evaluate};
use super::journal::Journal;
use super::layers::frozen;
use super::matched::{Matched, displacement_scale};
use super::schedule::rate_at;
use super::sparsity::shrink;
use super::split::{Split, set_aside};
use super::train_spec::{Keep, TrainSpec};
use super::unmatched::Unmatched;
use super::validation::{Validation, validate};
use super::window::Window;
use super::windows::Windows;
use crate::config::write_whole;
use crate::metric::{CostSpec, ShapeLoss};
use crate::model::{Cost, WorldModel};
use crate::state::Particles;
use crate::watch::Watch;
use anyhow::Context;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::ops::Range;
use std::path::Path;

/// Fits weights to data by gradient descent.
#[derive(Clone, Debug)]
pub struct Trainer {
    pub(super) spec: TrainSpec,
}

/// What a finished training reports, also in `train.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Trained {
    /// Steps done.
    pub steps: u64,
    /// The step whose weights were kept.
    pub kept: u64,
    /// Number of weights.
    pub weights: usize,
    /// The typical displacement that errors were divided by \[m\].
    pub scale: f64,
    /// Time spent \[s\].
    pub seconds: f64,
    /// The kept weights on episodes that neither training nor the choice of weights has seen.
    pub held_out: Option<Evaluation>,
}

/// A line of `metrics.jsonl`.
#[derive(Serialize)]
struct Line {
    step: u64,
    /// Mean since the last line.
    loss: f64,
    /// Mean since the last line, before clipping.
    gradient_norm: f64,
    rate: f64,
    seconds: f64,
    #[serde(flatten)]
    validation: Option<Validation>,
}

impl Trainer {
    /// Trains `model` in place, or goes on where a run in `folder` stopped.
    ///
    /// Writes `checkpoint.bin`, `metrics.jsonl`, the same for TensorBoard and, at the end, `train.json` into `folder`. The weights at
    /// the end do not depend on the number of threads, nor on where the run was stopped in between.
    ///
    /// # Errors
    /// When the data cannot be used, the model has no weights or no derivatives, a loss is not finite, a file cannot be
    /// written, or `watch` asks to stop (then everything is saved first).
    pub fn train(
        &self,
        model: &mut dyn WorldModel,
        split: &Split,
        folder: &Path,
        watch: &Watch,
    ) -> anyhow::Result<Trained> {
        let spec = &self.spec;
        let (fitted, aside) = set_aside(&split.train, spec.validation);
        let scale = displacement_scale(fitted.iter().copied(), spec.motion)?;
        let windows = Windows::new(fitted.iter().copied(), &split.tools, spec.horizon, spec.motion)?;
        let validation = Windows::new(aside.iter().copied(), &split.tools, spec.validation_horizon, spec.motion)?;
        let validation = validation.spread(spec.validation_windows);
        let loss = spec.loss.clone().map(CostSpec::build).transpose()?;
        windows.iter().try_for_each(|w| model.accepts(&w.scene)).context("the model cannot start from the data")?;
        let weights = model.weights();
        anyhow::ensure!(!weights.is_empty(), "the model has no weights to train; choose a model with a learned part");

        anyhow::ensure!(
            spec.sparsity == 0.0 || windows.iter().any(|w| !model.messages(&w.scene, &w.controls[0]).is_empty()),
            "`sparsity` of the training config shrinks messages, and the model sends none in the data; it needs a law of kind \
             \"learned_pair\" within whose reach something is"
        );

        let frozen = frozen(&model.matrices(), &spec.layers)?;
        std::fs::create_dir_all(folder).with_context(|| format!("cannot create {}", folder.display()))?;
        let path = folder.join("checkpoint.bin");
        let identity = self.identity(&weights, scale)?;
        let mut state = load(&path, &identity)?.unwrap_or_else(|| Checkpoint::new(weights));
        let mut journal = Journal::open(folder, state.step)?;
        let bar = watch.stage("train", spec.steps).with_position(state.step);
        bar.reset_eta();
        let before = state.seconds;
        model.set_weights(&state.weights);
        while state.step < spec.steps {
            let objective = Objective { scale, loss: loss.as_deref(), frozen: &frozen };
            let rate = self.advance(model, &windows, &objective, &mut state)?;
            state.seconds = before + bar.elapsed().as_secs_f64();
            bar.inc(1);
            let due = |every: u64| state.step.is_multiple_of(every) || state.step == spec.steps;
            let (log, judge) = (due(spec.log_every), due(spec.validate_every));
            if log || judge {
                let validation = if judge { validate(model, &validation, loss.as_deref())? } else { None };
                if let Some(validation) = &validation {
                    keep_best(&mut state, validation);
                }
                let (count, loss, norm) = std::mem::take(&mut state.since);
                let mean = |sum: f64| sum / count as f64;
                let (loss, gradient_norm, seconds) = (mean(loss), mean(norm), state.seconds);
                journal.line(&Line { step: state.step, loss, gradient_norm, rate, seconds, validation })?;
                bar.set_message(format!("loss {loss:.4}"));
                save(&path, &identity, &state)?;
            }
            if watch.stopped() && state.step < spec.steps {
                save(&path, &identity, &state)?;
                let (step, steps) = (state.step, spec.steps);
                watch.go_on(|| {
                    format!("training stopped after step {step} of {steps}; the same command goes on from there")
                })?;
            }
        }
        bar.finish();
        self.finish(model, state, scale, split, folder)
    }

    /// One step: draws a batch, sums its gradients in their order, clips, and lets Adam move the weights.
    fn advance(
        &self,
        model: &mut dyn WorldModel,
        windows: &Windows<'_>,
        objective: &Objective<'_>,
        state: &mut Checkpoint,
    ) -> anyhow::Result<f64> {
        let (spec, step) = (&self.spec, state.step + 1);
        let mut rng = ChaCha8Rng::seed_from_u64(spec.seed);
        rng.set_stream(step);
        let (episodes, batch): (Vec<usize>, Vec<Window<'_>>) = (0..spec.batch)
            .map(|_| {
                let (episode, mut window) = windows.draw(spec.moving, &mut rng);
                window.turn(rng.random_range(-1.0..=1.0) * spec.turn);
                window.disturb(spec.noise, &mut rng);
                window.shorten(spec.length_at(step));
                (episode, window)
            })
            .unzip();
        let fixed = &*model;
        let gradients: Option<Vec<_>> = batch
            .into_par_iter()
            .map(|window| {
                let part = spec.unroll.part(fixed, window);
                let mut gradient =
                    fixed.weight_gradient(&part.scene, &part.controls, &*objective.cost(&part.targets))?;
                if spec.sparsity > 0.0 {
                    gradient.cost +=
                        shrink(fixed, &part.scene, &part.controls[0], spec.sparsity, &mut gradient.weights);
                }
                Some(gradient)
            })
            .collect();
        let gradients = gradients.context("the model has no derivatives, so it cannot be trained")?;
        let share = 1.0 / gradients.len() as f64;
        let loss = share * gradients.iter().map(|g| g.cost).sum::<f64>();
        let mut sum = vec![0.0_f32; state.weights.len()];
        for gradient in &gradients {
            sum.iter_mut().zip(&gradient.weights).for_each(|(s, g)| *s += share as f32 * g);
        }
        // Before clipping, so that what stands still does not shorten the steps of what moves.
        objective.frozen.iter().for_each(|place| sum[place.clone()].fill(0.0));
        let norm = clip(&mut sum, spec.clip);
        if !loss.is_finite() || !norm.is_finite() {
            let mut episodes: Vec<String> = episodes.iter().map(usize::to_string).collect();
            episodes.dedup();
            anyhow::bail!(
                "training stopped before step {step}: its loss is {loss} and its gradient's length {norm} (training \
                 episodes {}); lower `rate` or `horizon`; the weights before it are untouched",
                episodes.join(", ")
            );
        }
        let rate = rate_at(step, spec.steps, spec.warm_up, spec.rate, spec.last_rate);
        state.adam.step(step, &mut state.weights, &sum, rate);
        model.set_weights(&state.weights);
        state.step = step;
        state.since = (state.since.0 + 1, state.since.1 + loss, state.since.2 + norm);
        Ok(rate)
    }

    fn finish(
        &self,
        model: &mut dyn WorldModel,
        state: Checkpoint,
        scale: f64,
        split: &Split,
        folder: &Path,
    ) -> anyhow::Result<Trained> {
        let kept = match (self.spec.keep, state.best) {
            (Keep::Best, Some(best)) => {
                model.set_weights(&best.weights);
                best.step
            }
            _ => state.step,
        };
        let judged = !split.held_out.is_empty();
        let held_out = judged.then(|| evaluate(model, &split.held_out, &split.tools)).transpose()?;
        let (steps, seconds, weights) = (state.step, state.seconds, state.weights.len());
        let trained = Trained { steps, kept, weights, scale, seconds, held_out };
        write_whole(&folder.join("train.json"), &serde_json::to_vec_pretty(&trained)?)?;
        Ok(trained)
    }

    /// What a checkpoint must have been made by to be continued here: this config, these first weights, this data.
    fn identity(&self, weights: &[f32], scale: f64) -> anyhow::Result<String> {
        let bytes: Vec<u8> = weights.iter().flat_map(|w| w.to_le_bytes()).collect();
        let digest = Sha256::digest(bytes).iter().map(|b| format!("{b:02x}")).collect::<String>();
        Ok(format!("{} {digest} {:x}", serde_json::to_string(&self.spec)?, scale.to_bits()))
    }
}

/// What is minimised.
struct Objective<'a> {
    scale: f64,
    loss: Option<&'a dyn ShapeLoss>,
    /// Places of the weights that it is not minimised over.
    frozen: &'a [Range<usize>],
}

impl<'a> Objective<'a> {
    fn cost(&self, targets: &'a [Particles]) -> Box<dyn Cost + 'a> {
        match self.loss {
            Some(loss) => Box::new(Unmatched { targets, scale: self.scale, loss }),
            None => Box::new(Matched { targets, scale: self.scale }),
        }
    }
}

fn keep_best(state: &mut Checkpoint, validation: &Validation) {
    let error = validation.shape.unwrap_or(validation.rollout);
    if state.best.as_ref().map_or(f64::INFINITY, |b| b.error) > error {
        state.best = Some(Best { error, step: state.step, weights: state.weights.clone() });
    }
}
