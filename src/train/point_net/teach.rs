//! The loop that fits a network of two clouds to examples.
use super::clouds::POINT;
use super::{Clouds, PointNetSpec};
use crate::config::{hold, write_whole};
use crate::model::net::{Judge, PointNet, PointNetArchitecture, Trainable, forward, pull};
use crate::train::adam::clip;
use crate::train::checkpoint::{Best, Checkpoint, load, save};
use crate::train::journal::Journal;
use crate::train::rate_at;
use crate::watch::Watch;
use anyhow::ensure;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use serde::Serialize;
use sha2::{Digest, Sha256};
use std::path::Path;

/// Two clouds, and what a network should say of them.
pub(in crate::train) struct Example<T> {
    pub(in crate::train) clouds: Clouds,
    pub(in crate::train) target: T,
}

/// The loss of what the network says of an example, and its derivative by that.
type Loss<'a, T> = dyn Fn(&[f32], &T) -> (f64, Vec<f32>) + Sync + 'a;

/// What is to be learned.
pub(in crate::train) struct Lesson<'a, T> {
    pub(in crate::train) examples: Vec<Example<T>>,
    pub(in crate::train) loss: &'a Loss<'a, T>,
    /// Greatest angle about the vertical by which examples are turned at random \[rad\].
    pub(in crate::train) turn: f64,
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
    #[serde(skip_serializing_if = "Option::is_none")]
    validation: Option<f64>,
}

/// The weights that a finished training left; their presence says that it has finished.
const WEIGHTS: &str = "weights.safetensors";
/// Examples whose gradients are taken together: as many whatever the number of threads, so that sums are the same.
const TOGETHER: usize = 8;

/// What a network says of some pairs of clouds, a row each.
pub(in crate::train) fn said(net: &PointNet, clouds: &[&Clouds]) -> Vec<f32> {
    let (points, counts) = stacked(clouds.iter().copied());
    forward(&Judge { net, counts: &counts }, vec![(points, POINT)])
}

fn stacked<'a>(clouds: impl Iterator<Item = &'a Clouds> + Clone) -> (Vec<f32>, Vec<usize>) {
    (clouds.clone().flat_map(|c| c.points.concat()).collect(), clouds.flat_map(|c| c.counts).collect())
}

/// The network with weights fitted to what `lesson` gives, or as an earlier run left it in `folder`, or fitted from where one stopped.
///
/// # Errors
/// When the lesson fails, a loss is not finite, a file cannot be written, or `watch` asks to stop (then everything is saved first).
pub(in crate::train) fn taught<'a, T: Sync + 'a>(
    spec: &PointNetSpec,
    outputs: usize,
    lesson: impl FnOnce() -> anyhow::Result<Option<Lesson<'a, T>>>,
    folder: &Path,
    watch: &Watch,
) -> anyhow::Result<Option<PointNet>> {
    spec.check()?;
    let _held = hold(folder)?;
    let net = PointNet::new(PointNetArchitecture { width: spec.width, outputs }, spec.seed);
    let path = folder.join(WEIGHTS);
    if path.exists() {
        return net.loaded(Some(&path)).map(Some);
    }
    let Some(lesson) = lesson()? else { return Ok(None) };
    let mut net = net;
    lesson.teach(spec, &mut net, folder, watch)?;
    net.save(&path)?;
    Ok(Some(net))
}

impl<T: Sync> Lesson<'_, T> {
    fn teach(&self, spec: &PointNetSpec, net: &mut PointNet, folder: &Path, watch: &Watch) -> anyhow::Result<()> {
        let count = self.examples.len();
        let aside = ((spec.validation * count as f64).ceil() as usize).min(count.saturating_sub(1));
        let (fitted, aside) = self.examples.split_at(count - aside);
        ensure!(!fitted.is_empty(), "there is no example to learn from");
        let (path, identity) = (folder.join("checkpoint.bin"), self.identity(spec)?);
        let mut state = load(&path, &identity)?.unwrap_or_else(|| Checkpoint::new(net.weights()));
        let mut journal = Journal::open(folder, state.step)?;
        let bar = watch.stage("teach", spec.steps).with_position(state.step);
        bar.reset_eta();
        let before = state.seconds;
        net.set_weights(&state.weights);
        while state.step < spec.steps {
            let rate = self.advance(spec, net, fitted, &mut state)?;
            state.seconds = before + bar.elapsed().as_secs_f64();
            bar.inc(1);
            if state.step.is_multiple_of(spec.log_every) || state.step == spec.steps {
                let validation = (!aside.is_empty()).then(|| self.error(net, aside));
                if let Some(error) = validation
                    && state.best.as_ref().map_or(f64::INFINITY, |best| best.error) > error
                {
                    state.best = Some(Best { error, step: state.step, weights: state.weights.clone() });
                }
                let (steps, loss, norm) = std::mem::take(&mut state.since);
                let mean = |sum: f64| sum / steps as f64;
                let (loss, gradient_norm, seconds) = (mean(loss), mean(norm), state.seconds);
                journal.line(&Line { step: state.step, loss, gradient_norm, rate, seconds, validation })?;
                save(&path, &identity, &state)?;
            }
            if watch.stopped() && state.step < spec.steps {
                save(&path, &identity, &state)?;
                let (step, steps) = (state.step, spec.steps);
                watch.go_on(|| format!("teaching stopped after step {step} of {steps}; the same command goes on"))?;
            }
        }
        bar.finish_and_clear();
        let kept = state.best.as_ref().map_or(state.step, |best| best.step);
        let report = serde_json::json!({ "steps": state.step, "kept": kept, "examples": count,
            "validation": state.best.as_ref().map(|best| best.error), "seconds": state.seconds });
        write_whole(&folder.join("taught.json"), &serde_json::to_vec_pretty(&report)?)?;
        if let Some(best) = state.best {
            net.set_weights(&best.weights);
        }
        Ok(())
    }

    /// One step: draws a batch, sums its gradients in their order, clips, and lets Adam move the weights.
    fn advance(
        &self,
        spec: &PointNetSpec,
        net: &mut PointNet,
        examples: &[Example<T>],
        state: &mut Checkpoint,
    ) -> anyhow::Result<f64> {
        let step = state.step + 1;
        let mut rng = ChaCha8Rng::seed_from_u64(spec.seed);
        rng.set_stream(step);
        let noise = spec.noise / spec.extent;
        let batch: Vec<(Clouds, &T)> = (0..spec.batch)
            .map(|_| {
                let Example { clouds, target } = &examples[rng.random_range(0..examples.len())];
                (clouds.disturbed(self.turn, noise, &mut rng), target)
            })
            .collect();
        let fixed = &*net;
        let gradients: Vec<(f64, Vec<f32>)> =
            batch.par_chunks(TOGETHER).map(|some| self.gradient(fixed, some)).collect();
        let share = 1.0 / spec.batch as f64;
        let loss = share * gradients.iter().map(|(loss, _)| loss).sum::<f64>();
        let mut sum = vec![0.0_f32; state.weights.len()];
        for (_, gradient) in &gradients {
            sum.iter_mut().zip(gradient).for_each(|(s, g)| *s += share as f32 * g);
        }
        let norm = clip(&mut sum, spec.clip);
        ensure!(
            loss.is_finite() && norm.is_finite(),
            "teaching stopped before step {step}: its loss is {loss} and its gradient's length {norm}; lower `network.rate`"
        );
        let rate = rate_at(step, spec.steps, spec.warm_up, spec.rate, spec.last_rate);
        state.adam.step(step, &mut state.weights, &sum, rate);
        net.set_weights(&state.weights);
        state.step = step;
        state.since = (state.since.0 + 1, state.since.1 + loss, state.since.2 + norm);
        Ok(rate)
    }

    /// Sum of losses, and its derivative by the weights.
    fn gradient(&self, net: &PointNet, some: &[(Clouds, &T)]) -> (f64, Vec<f32>) {
        let (points, counts) = stacked(some.iter().map(|(clouds, _)| clouds));
        let judge = Judge { net, counts: &counts };
        let rows = forward(&judge, vec![(points.clone(), POINT)]);
        let outputs = rows.len() / some.len();
        let judged = rows.chunks_exact(outputs).zip(some).map(|(row, (_, target))| (self.loss)(row, target));
        let (losses, at): (Vec<f64>, Vec<Vec<f32>>) = judged.unzip();
        let mut weights = vec![0.0; net.weights().len()];
        pull(&judge, vec![(points, POINT)], &at.concat(), &mut weights);
        (losses.iter().sum(), weights)
    }

    /// Mean loss on undisturbed examples.
    fn error(&self, net: &PointNet, examples: &[Example<T>]) -> f64 {
        let loss = |e: &Example<T>| (self.loss)(&said(net, &[&e.clouds]), &e.target).0;
        examples.par_iter().map(loss).collect::<Vec<_>>().iter().sum::<f64>() / examples.len() as f64
    }

    /// What a checkpoint must have been made by to be continued here: this config and these clouds.
    fn identity(&self, spec: &PointNetSpec) -> anyhow::Result<String> {
        let mut hash = Sha256::new();
        for number in self.examples.iter().flat_map(|e| e.clouds.points.iter().flatten()) {
            hash.update(number.to_le_bytes());
        }
        let digest = hash.finalize().iter().map(|b| format!("{b:02x}")).collect::<String>();
        Ok(format!("{} {digest}", serde_json::to_string(spec)?))
    }
}
