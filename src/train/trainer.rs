//! Training of whatever a world model has learned, a pure network and the learned law of a hybrid alike.
use super::evaluate::{Evaluation, evaluate};
use super::layers::frozen;
use super::matched::{Matched, displacement_scale};
use super::sparsity::shrink;
use super::split::{Split, set_aside};
use super::train_spec::TrainSpec;
use super::training_loop::{Batch, Learned, Learner, TrainingLoop, digest};
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
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
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
        anyhow::ensure!(
            spec.patience.is_none() || !validation.is_empty(),
            "`patience` of the training config counts validations, and no tool has two training episodes, so that none could be \
             set aside to validate on; leave `patience` out or record more"
        );
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
        let course = TrainingLoop {
            steps: spec.steps,
            batch: spec.batch,
            rate: spec.rate,
            warm_up: spec.warm_up,
            last_rate: spec.last_rate,
            clip: spec.clip,
            validate_every: spec.validate_every,
            patience: spec.patience,
            log_every: spec.log_every,
            keep: spec.keep,
            seed: spec.seed,
            identity: self.identity(&weights, scale)?,
            folder,
            watch,
        };
        let mut pupil = Pupil { spec, model, windows, validation, scale, loss, frozen };
        let Learned { steps, kept, seconds, .. } = course.run(&mut pupil)?;
        let judged = !split.held_out.is_empty();
        let held_out = judged.then(|| evaluate(pupil.model, &split.held_out, &split.tools)).transpose()?;
        let trained = Trained { steps, kept, weights: weights.len(), scale, seconds, held_out };
        write_whole(&folder.join("train.json"), &serde_json::to_vec_pretty(&trained)?)?;
        Ok(trained)
    }

    /// What a checkpoint must have been made by to be continued here: this config, these first weights, this data.
    fn identity(&self, weights: &[f32], scale: f64) -> anyhow::Result<String> {
        let digest = digest(weights.iter().map(|w| w.to_le_bytes()));
        Ok(format!("{} {digest} {:x}", serde_json::to_string(&self.spec)?, scale.to_bits()))
    }
}

/// A world model and the windows of recorded motion that it learns from.
struct Pupil<'a> {
    spec: &'a TrainSpec,
    model: &'a mut dyn WorldModel,
    windows: Windows<'a>,
    validation: Vec<Window<'a>>,
    scale: f64,
    loss: Option<Box<dyn ShapeLoss>>,
    /// Places of the weights that stay as they are.
    frozen: Vec<Range<usize>>,
}

impl Pupil<'_> {
    /// What is minimised on a window.
    fn cost<'c>(&'c self, targets: &'c [Particles]) -> Box<dyn Cost + 'c> {
        match &self.loss {
            Some(loss) => Box::new(Unmatched { targets, scale: self.scale, loss: loss.as_ref() }),
            None => Box::new(Matched { targets, scale: self.scale }),
        }
    }

    fn gradient(&self, window: Window<'_>) -> Option<(f64, Vec<f32>)> {
        let (spec, model) = (self.spec, &*self.model);
        let part = spec.unroll.part(model, window);
        let mut gradient = model.weight_gradient(&part.scene, &part.controls, &*self.cost(&part.targets))?;
        if spec.sparsity > 0.0 {
            gradient.cost += shrink(model, &part.scene, &part.controls[0], spec.sparsity, &mut gradient.weights);
        }
        // Before clipping, so that what stands still does not shorten the steps of what moves.
        self.frozen.iter().for_each(|place| gradient.weights[place.clone()].fill(0.0));
        Some((gradient.cost, gradient.weights))
    }
}

impl Learner for Pupil<'_> {
    type Verdict = Validation;

    fn weights(&self) -> Vec<f32> {
        self.model.weights()
    }

    fn set_weights(&mut self, weights: &[f32]) {
        self.model.set_weights(weights);
    }

    fn batch(&self, step: u64, rng: &mut ChaCha8Rng) -> anyhow::Result<Batch> {
        let spec = self.spec;
        let (drawn, windows): (Vec<usize>, Vec<Window<'_>>) = (0..spec.batch)
            .map(|_| {
                let (episode, mut window) = self.windows.draw(spec.moving, rng);
                window.turn(rng.random_range(-1.0..=1.0) * spec.turn);
                window.disturb(spec.noise, rng);
                window.shorten(spec.length_at(step));
                (episode, window)
            })
            .unzip();
        let parts: Option<Vec<_>> = windows.into_par_iter().map(|window| self.gradient(window)).collect();
        Ok(Batch { drawn, parts: parts.context("the model has no derivatives, so it cannot be trained")? })
    }

    fn judge(&self) -> anyhow::Result<Option<Validation>> {
        validate(&*self.model, &self.validation, self.loss.as_deref())
    }

    fn error(validation: &Validation) -> f64 {
        validation.shape.unwrap_or(validation.rollout)
    }

    fn advice(&self, drawn: &[usize]) -> String {
        let mut episodes: Vec<String> = drawn.iter().map(usize::to_string).collect();
        episodes.dedup();
        format!("(training episodes {}); lower `rate` or `horizon`", episodes.join(", "))
    }
}
