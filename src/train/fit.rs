//! Stages that fit a model to data: what a model's config lists under `train`.
use super::constants::{put, without};
use super::distil::DistilSpec;
use super::{Identifier, IdentifySpec, Split, TrainSpec, Trainer};
use crate::model::ModelSpec;
use crate::watch::Watch;
use anyhow::Context;
use serde_json::{Value, json};
use std::path::Path;

/// A stage that fits a model to data.
pub trait Fit: Send + Sync {
    /// The model's config with fitted constants, or with the file of its trained weights; everything that the stage
    /// writes lies in `folder`, and a stage that was stopped goes on from there.
    ///
    /// # Errors
    /// When the model or the data do not suit the stage, a file cannot be written, or `watch` asks to stop (then
    /// everything is saved first).
    fn fit(&self, model: &ModelSpec, data: &Split, folder: &Path, watch: &Watch) -> anyhow::Result<ModelSpec>;
}

family! {
    /// Every fitting stage that a config can name.
    FitSpec builds Box<dyn Fit> {
        Train(TrainSpec),
        Identify(IdentifySpec),
        Distil(DistilSpec),
    }
}

impl Fit for Trainer {
    fn fit(&self, model: &ModelSpec, data: &Split, folder: &Path, watch: &Watch) -> anyhow::Result<ModelSpec> {
        let path = folder.join("weights.safetensors");
        let fitted = read(&put(&written(model)?, &self.spec.weights, json!(path))?)?;
        let mut world = model.clone().build()?;
        self.train(&mut *world, data, folder, watch)?;
        world.save_weights(&path)?;
        Ok(fitted)
    }
}

impl Fit for Identifier {
    fn fit(&self, model: &ModelSpec, data: &Split, folder: &Path, watch: &Watch) -> anyhow::Result<ModelSpec> {
        let left_out = &self.spec.leave_out;
        let build =
            |spec: &Value| read(&left_out.iter().try_fold(spec.clone(), |spec, path| without(&spec, path))?)?.build();
        let (fitted, _) = self.identify(&written(model)?, &build, data, folder, watch)?;
        read(&fitted)
    }
}

fn written(model: &ModelSpec) -> anyhow::Result<Value> {
    serde_json::to_value(model).context("the model's config cannot be written as JSON")
}

fn read(model: &Value) -> anyhow::Result<ModelSpec> {
    serde_json::from_value(model.clone()).context("the fitted constants do not make a model's config")
}
