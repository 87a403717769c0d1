//! Fitting a network of two clouds to examples.
use super::clouds::POINT;
use super::{Clouds, PointNetSpec};
use crate::config::{hold, vacate, write_whole};
use crate::model::net::{Judge, PointNet, PointNetArchitecture, Trainable, forward, pull};
use crate::train::Keep;
use crate::train::training_loop::{Batch, Learned, Learner, TrainingLoop, digest};
use crate::watch::Watch;
use anyhow::ensure;
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use serde::Serialize;
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
    let held = hold(folder)?;
    let net = PointNet::new(PointNetArchitecture { width: spec.width, outputs }, spec.seed);
    let path = folder.join(WEIGHTS);
    if path.exists() {
        return net.loaded(Some(&path)).map(Some);
    }
    let Some(lesson) = lesson()? else {
        vacate(held, folder);
        return Ok(None);
    };
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
        let course = TrainingLoop {
            steps: spec.steps,
            batch: spec.batch,
            rate: spec.rate,
            warm_up: spec.warm_up,
            last_rate: spec.last_rate,
            clip: spec.clip,
            validate_every: spec.log_every,
            patience: None,
            log_every: spec.log_every,
            keep: Keep::Best,
            seed: spec.seed,
            identity: self.identity(spec)?,
            folder,
            watch,
        };
        let Learned { steps, kept, error, seconds } =
            course.run(&mut Pupil { lesson: self, spec, net, fitted, aside })?;
        let report = serde_json::json!({ "steps": steps, "kept": kept, "examples": count, "validation": error,
            "seconds": seconds });
        write_whole(&folder.join("taught.json"), &serde_json::to_vec_pretty(&report)?)
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

    /// What a checkpoint must have been made by to be continued here: this config and these clouds.
    fn identity(&self, spec: &PointNetSpec) -> anyhow::Result<String> {
        let numbers = self.examples.iter().flat_map(|e| e.clouds.points.iter().flatten());
        Ok(format!("{} {}", serde_json::to_string(spec)?, digest(numbers.map(|number| number.to_le_bytes()))))
    }
}

/// A network and the examples that it learns from.
struct Pupil<'a, T> {
    lesson: &'a Lesson<'a, T>,
    spec: &'a PointNetSpec,
    net: &'a mut PointNet,
    fitted: &'a [Example<T>],
    aside: &'a [Example<T>],
}

/// Mean loss on undisturbed examples that are not trained on.
#[derive(Serialize)]
struct Verdict {
    validation: f64,
}

impl<T: Sync> Learner for Pupil<'_, T> {
    type Verdict = Verdict;

    fn weights(&self) -> Vec<f32> {
        self.net.weights()
    }

    fn set_weights(&mut self, weights: &[f32]) {
        self.net.set_weights(weights);
    }

    fn batch(&self, _: u64, rng: &mut ChaCha8Rng) -> anyhow::Result<Batch> {
        let noise = self.spec.noise / self.spec.extent;
        let (drawn, examples): (Vec<usize>, Vec<(Clouds, &T)>) = (0..self.spec.batch)
            .map(|_| {
                let place = rng.random_range(0..self.fitted.len());
                let Example { clouds, target } = &self.fitted[place];
                (place, (clouds.disturbed(self.lesson.turn, noise, rng), target))
            })
            .unzip();
        let net = &*self.net;
        let parts = examples.par_chunks(TOGETHER).map(|some| self.lesson.gradient(net, some)).collect();
        Ok(Batch { drawn, parts })
    }

    fn judge(&self) -> anyhow::Result<Option<Verdict>> {
        let loss = |e: &Example<T>| (self.lesson.loss)(&said(self.net, &[&e.clouds]), &e.target).0;
        let losses: Vec<f64> = self.aside.par_iter().map(loss).collect();
        Ok((!losses.is_empty()).then(|| Verdict { validation: losses.iter().sum::<f64>() / losses.len() as f64 }))
    }

    fn error(verdict: &Verdict) -> f64 {
        verdict.validation
    }

    fn advice(&self, drawn: &[usize]) -> String {
        let places: Vec<String> = drawn.iter().map(usize::to_string).collect();
        format!("(examples {}); lower `network.rate`", places.join(", "))
    }
}
