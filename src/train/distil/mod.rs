//! Distillation: the messages of a trained network, read back as formulas (Cranmer et al. 2020).
//!
//! A pair law's network is asked what it says in recorded scenes; genetic programming finds formulas of the same invariants, none
//! beaten by a simpler one; the one that is believed takes the network's place, so that the model is written from then on.
mod fitted;
mod front;
mod heard;
mod island;
mod law;
mod samples;
mod search;
mod spec;
mod tree;
mod variation;

pub use fitted::Fitted;
pub use front::Front;
pub use heard::{Component, Encounter, Heard};
pub use samples::{Samples, Variable};
pub use search::regress;
pub use spec::DistilSpec;

use super::{Fit, Split};
use crate::config::write_whole;
use crate::graph::kinds_named;
use crate::model::ModelSpec;
use crate::model::law::formula::{Between, FormulaSpec, Reach};
use crate::model::law::{LawSpec, LearnedPairSpec, Message};
use crate::watch::Watch;
use anyhow::{Context, bail, ensure};
use indexmap::IndexMap;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Reads messages as formulas.
#[derive(Clone, Debug)]
pub struct Distiller {
    pub(super) spec: DistilSpec,
}

/// A formula of a front: a line of `front.jsonl`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Candidate {
    /// Name of the edges whose messages it was fitted to.
    pub edge: String,
    /// `normal_force` or `tangential_force`.
    pub force: String,
    /// As a law's config has it.
    pub formula: String,
    /// Its constants.
    pub constants: IndexMap<String, f64>,
    /// Number of its variables, constants and operations.
    pub complexity: usize,
    /// `√(Σ (f − y)²/Σ y²)` over the messages y that it was fitted to.
    pub fit: f64,
    /// Over those that it was chosen by.
    pub validation: f64,
    /// Over those that neither has seen; none where there are none.
    pub held_out: Option<f64>,
    /// Whether it is the one that is believed.
    pub chosen: bool,
}

/// What messages of one kind were read as.
#[derive(Clone, Debug, Default)]
pub struct Reading {
    /// The law of the formulas that are believed; none where every component is dead.
    pub law: Option<FormulaSpec>,
    /// All formulas that no simpler one beats.
    pub front: Vec<Candidate>,
}

impl Distiller {
    /// Finds formulas for the messages of one kind of meeting.
    ///
    /// # Errors
    /// As [`regress`].
    pub fn read(&self, heard: &Heard, encounter: &Encounter, watch: &Watch) -> anyhow::Result<Reading> {
        let some = |all: &[Message]| encounter.some(all, self.spec.meetings);
        let (fit, held_out) = (some(&heard.fit), some(&heard.held_out));
        let aside = some(if heard.validation.is_empty() { &heard.fit } else { &heard.validation });
        let size = fit.iter().map(|m| m.normal.powi(2) + m.tangential.powi(2)).sum::<f64>() / fit.len().max(1) as f64;
        let mut reading = Reading::default();
        let mut law = FormulaSpec {
            name: Some(format!("distilled_{}", encounter.edge)),
            between: encounter.between,
            wall: None,
            reach: Reach::Number(encounter.reach),
            energy: None,
            normal_force: None,
            tangential_force: None,
            constants: IndexMap::new(),
        };
        let force = size.sqrt();
        for component in [Component::Normal, Component::Tangential] {
            let of = |messages: &[Message]| encounter.samples(messages, component, force);
            let samples = of(&fit);
            if fit.is_empty() || force == 0.0 || samples.size() < self.spec.negligible {
                continue;
            }
            let called = || format!("the {} of {} edges", component.key(), encounter.edge);
            let front = regress(&self.spec, &samples, watch).with_context(called)?;
            let (aside, held_out) = (of(&aside), of(&held_out));
            let validation: Vec<f64> = front.formulas().iter().map(|one| one.error_on(&aside)).collect();
            let believed =
                front.believed(&validation).with_context(|| format!("{}: no formula has a value", called()))?;
            for (k, one) in front.formulas().iter().enumerate() {
                let written = encounter.written(one, component, force);
                if k == believed {
                    let place =
                        if component == Component::Normal { &mut law.normal_force } else { &mut law.tangential_force };
                    *place = Some(written.text.clone());
                    law.constants.extend(written.constants.clone());
                }
                reading.front.push(Candidate {
                    edge: encounter.edge.clone(),
                    force: component.key().to_owned(),
                    formula: written.text,
                    constants: written.constants,
                    complexity: one.form.complexity,
                    fit: one.error,
                    validation: validation[k],
                    held_out: (!held_out.target.is_empty()).then(|| one.error_on(&held_out)),
                    chosen: k == believed,
                });
            }
        }
        let alive = law.normal_force.is_some() || law.tangential_force.is_some();
        reading.law = alive.then_some(law);
        Ok(reading)
    }
}

/// The meetings that a learned pair law knows.
///
/// # Errors
/// When a name is no kind's.
pub fn encounters(spec: &LearnedPairSpec) -> anyhow::Result<Vec<Encounter>> {
    let kinds = kinds_named("edges", &spec.edges)?;
    let of = |(edge, kind): (&String, usize)| {
        let (between, reach) = match kind {
            0 => (Between::Particles, spec.radius),
            1 => (Between::Tool, spec.skin),
            _ => (Between::Floor, spec.skin),
        };
        Encounter { edge: edge.clone(), kind, between, reach, speed: spec.speed }
    };
    Ok(spec.edges.iter().zip(kinds).map(of).collect())
}

impl Fit for Distiller {
    fn fit(&self, model: &ModelSpec, data: &Split, folder: &Path, watch: &Watch) -> anyhow::Result<ModelSpec> {
        let ModelSpec::Particles(particles) = model else {
            bail!("only a model of kind \"particles\" has laws whose messages can be distilled");
        };
        let learned = |law: &LawSpec| matches!(law, LawSpec::LearnedPair(_));
        let places: Vec<usize> = (0..particles.laws.len()).filter(|k| learned(&particles.laws[*k])).collect();
        ensure!(
            places.len() == 1,
            "dynamics.laws holds {} laws of kind \"learned_pair\"; a distillation reads the messages of one",
            places.len()
        );
        let LawSpec::LearnedPair(pair) = &particles.laws[places[0]] else { unreachable!("it was just found") };
        let heard = self.listen(&*model.clone().build()?, data)?;
        let readings = encounters(pair)?
            .iter()
            .map(|encounter| self.read(&heard, encounter, watch))
            .collect::<anyhow::Result<Vec<_>>>()?;
        let lines = readings.iter().flat_map(|reading| &reading.front);
        let lines: String = lines.map(|line| serde_json::to_string(line).expect("plain data") + "\n").collect();
        write_whole(&folder.join(FRONT), lines.as_bytes())?;
        let mut written = particles.clone();
        let laws = readings.into_iter().filter_map(|reading| reading.law).map(LawSpec::Formula);
        written.laws.splice(places[0]..=places[0], laws);
        let distilled = ModelSpec::Particles(written);
        let whole = IndexMap::from([("dynamics", &distilled)]);
        let text = toml_edit::ser::to_string_pretty(&whole).context("the distilled model cannot be written as TOML")?;
        write_whole(&folder.join(MODEL), text.as_bytes())?;
        Ok(distilled)
    }
}

/// The file of a distillation's fronts.
pub const FRONT: &str = "front.jsonl";
/// The file of the model that it wrote.
pub const MODEL: &str = "model.toml";
