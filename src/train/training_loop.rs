//! The loop that everything learned is fitted by: world models, policies and classifiers alike.
use super::adam::clip;
use super::checkpoint::{Best, Checkpoint, load, save};
use super::journal::Journal;
use super::schedule::rate_at;
use super::train_spec::Keep;
use crate::watch::Watch;
use anyhow::Context;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde::Serialize;
use sha2::{Digest, Sha256};
use std::path::Path;

/// Weights that can be learned: what they are judged by, and how that changes with them.
pub(super) trait Learner {
    /// What is said of the weights at a validation, as it stands in `metrics.jsonl`.
    type Verdict: Serialize;
    /// The weights before the first step.
    fn weights(&self) -> Vec<f32>;
    /// Puts other weights in their place, as many.
    fn set_weights(&mut self, weights: &[f32]);
    /// The losses of a batch drawn by `rng` for optimiser step `step` ∈ 1.., and their gradients.
    fn batch(&self, step: u64, rng: &mut ChaCha8Rng) -> anyhow::Result<Batch>;
    /// How good the weights are on what is never trained on; `None` where nothing was set aside.
    fn judge(&self) -> anyhow::Result<Option<Self::Verdict>>;
    /// The number of a verdict that the best weights have the lowest of.
    fn error(verdict: &Self::Verdict) -> f64;
    /// What to try when the loss of a batch, of which this says what was `drawn`, is not finite.
    fn advice(&self, drawn: &[usize]) -> String;
}

/// What was drawn for one step, and what it says of the weights.
pub(super) struct Batch {
    /// Places of what was drawn.
    pub(super) drawn: Vec<usize>,
    /// Sums of losses and of their gradients over parts of the batch, which are the same whatever the number of threads.
    pub(super) parts: Vec<(f64, Vec<f32>)>,
}

/// How long the loop runs, how far it steps and what it keeps; the keys of [`super::TrainSpec`].
pub(super) struct TrainingLoop<'a> {
    pub(super) steps: u64,
    pub(super) batch: usize,
    pub(super) rate: f64,
    pub(super) warm_up: u64,
    pub(super) last_rate: f64,
    pub(super) clip: f64,
    pub(super) validate_every: u64,
    /// Only where [`Learner::judge`] has a verdict.
    pub(super) patience: Option<u64>,
    pub(super) log_every: u64,
    pub(super) keep: Keep,
    pub(super) seed: u64,
    /// What a checkpoint must have been made by to be continued: config, data, first weights.
    pub(super) identity: String,
    pub(super) folder: &'a Path,
    pub(super) watch: &'a Watch,
}

/// What a finished loop says of itself.
pub(super) struct Learned {
    /// Steps done.
    pub(super) steps: u64,
    /// The step whose weights were kept.
    pub(super) kept: u64,
    /// The lowest error of a validation.
    pub(super) error: Option<f64>,
    /// Time spent, that of earlier runs included \[s\].
    pub(super) seconds: f64,
}

/// A line of `metrics.jsonl`.
#[derive(Serialize)]
struct Line<V> {
    step: u64,
    /// Mean since the last line.
    loss: f64,
    /// Mean since the last line, before clipping.
    gradient_norm: f64,
    rate: f64,
    seconds: f64,
    #[serde(flatten)]
    validation: Option<V>,
    /// Why this line is the last, where there are steps left.
    #[serde(skip_serializing_if = "Option::is_none")]
    stopped: Option<String>,
}

impl TrainingLoop<'_> {
    /// Fits the weights of `learner`, or goes on where a run in the folder stopped, and leaves it those that are to be kept.
    ///
    /// Writes `checkpoint.bin`, `metrics.jsonl` and the same for TensorBoard. The weights do not depend on the number of threads, nor on
    /// where the run was stopped in between.
    ///
    /// # Errors
    /// When a batch fails, a loss is not finite, a file cannot be written, or `watch` asks to stop (then everything is saved first).
    pub(super) fn run<L: Learner>(&self, learner: &mut L) -> anyhow::Result<Learned> {
        let Self { steps, folder, watch, identity, .. } = self;
        std::fs::create_dir_all(folder).with_context(|| format!("cannot create {}", folder.display()))?;
        let path = folder.join("checkpoint.bin");
        let mut state = load(&path, identity)?.unwrap_or_else(|| Checkpoint::new(learner.weights()));
        let mut journal = Journal::open(folder, state.step)?;
        let bar = watch.stage("train", *steps).with_position(state.step);
        bar.reset_eta();
        let before = state.seconds;
        learner.set_weights(&state.weights);
        let over = |state: &Checkpoint| state.step == *steps || self.stalled(state).is_some();
        while !over(&state) {
            let rate = self.advance(learner, &mut state)?;
            state.seconds = before + bar.elapsed().as_secs_f64();
            bar.inc(1);
            let due = |every: u64| state.step.is_multiple_of(every) || state.step == *steps;
            let (log, judge) = (due(self.log_every), due(self.validate_every));
            if log || judge {
                let validation = if judge { learner.judge()? } else { None };
                if let Some(verdict) = &validation {
                    keep_best(&mut state, L::error(verdict));
                }
                let (count, loss, norm) = std::mem::take(&mut state.since);
                let mean = |sum: f64| sum / count as f64;
                let (loss, gradient_norm, seconds, stopped) =
                    (mean(loss), mean(norm), state.seconds, self.stalled(&state));
                if let Some(reason) = &stopped {
                    bar.println(format!("training stopped after step {} of {steps}: {reason}", state.step));
                }
                journal.line(&Line { step: state.step, loss, gradient_norm, rate, seconds, validation, stopped })?;
                bar.set_message(format!("loss {loss:.4}"));
                save(&path, identity, &state)?;
            }
            if watch.stopped() && !over(&state) {
                save(&path, identity, &state)?;
                let step = state.step;
                watch.go_on(|| {
                    format!("training stopped after step {step} of {steps}; the same command goes on from there")
                })?;
            }
        }
        bar.finish_and_clear();
        let Checkpoint { step: steps, best, seconds, .. } = state;
        let error = best.as_ref().map(|best| best.error);
        let kept = match (self.keep, best) {
            (Keep::Best, Some(best)) => {
                learner.set_weights(&best.weights);
                best.step
            }
            _ => steps,
        };
        Ok(Learned { steps, kept, error, seconds })
    }

    /// Why the run ends before its last step, if it does: `patience` validations in a row were no better than the best.
    ///
    /// It follows from the checkpoint alone, as validations are at fixed steps: a resumed run ends where it would have ended.
    fn stalled(&self, state: &Checkpoint) -> Option<String> {
        let best = state.best.as_ref().map_or(0, |best| best.step);
        let since = state.step / self.validate_every - best / self.validate_every;
        let patience = self.patience.filter(|patience| state.step < self.steps && since >= *patience)?;
        Some(match best {
            0 => format!("none of {patience} validations had a finite error"),
            _ => format!("no validation after step {best} had a lower error than it, {patience} in a row"),
        })
    }

    /// One step: sums the gradients of a batch in their order, clips, and lets Adam move the weights.
    fn advance<L: Learner>(&self, learner: &mut L, state: &mut Checkpoint) -> anyhow::Result<f64> {
        let step = state.step + 1;
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(step);
        let Batch { drawn, parts } = learner.batch(step, &mut rng)?;
        let share = 1.0 / self.batch as f64;
        let loss = share * parts.iter().map(|(loss, _)| loss).sum::<f64>();
        let mut sum = vec![0.0_f32; state.weights.len()];
        for (_, gradient) in &parts {
            sum.iter_mut().zip(gradient).for_each(|(s, g)| *s += share as f32 * g);
        }
        let norm = clip(&mut sum, self.clip);
        anyhow::ensure!(
            loss.is_finite() && norm.is_finite(),
            "training stopped before step {step}: its loss is {loss} and its gradient's length {norm} {}; the weights before it are \
             untouched",
            learner.advice(&drawn)
        );
        let rate = rate_at(step, self.steps, self.warm_up, self.rate, self.last_rate);
        state.adam.step(step, &mut state.weights, &sum, rate);
        learner.set_weights(&state.weights);
        state.step = step;
        state.since = (state.since.0 + 1, state.since.1 + loss, state.since.2 + norm);
        Ok(rate)
    }
}

fn keep_best(state: &mut Checkpoint, error: f64) {
    if state.best.as_ref().map_or(f64::INFINITY, |best| best.error) > error {
        state.best = Some(Best { error, step: state.step, weights: state.weights.clone() });
    }
}

/// SHA-256 of numbers as they lie in memory, for [`TrainingLoop::identity`].
pub(super) fn digest<const N: usize>(numbers: impl Iterator<Item = [u8; N]>) -> String {
    let mut hash = Sha256::new();
    numbers.for_each(|bytes| hash.update(bytes));
    hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}
