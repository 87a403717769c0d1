//! A classifier: which tool turned a workpiece into its goal, learned from simulated episodes.
mod report;

pub use report::{Report, Share};

use super::Split;
use super::point_net::{Clouds, Example, Lesson, PointNetSpec, said, taught};
use super::policy::log_softmax;
use crate::config::write_whole;
use crate::data::Episode;
use crate::model::net::PointNet;
use crate::watch::Watch;
use anyhow::{Context, ensure};
use glam::DVec3;
use std::path::Path;

/// A network that maps a workpiece and its goal to a distribution over tools (RoboCook, Shi et al. 2023).
#[derive(Clone, Debug)]
pub struct Classifier {
    net: PointNet,
    extent: f64,
    tools: Vec<String>,
}

/// What a classifier's folder says of it.
pub const REPORT: &str = "classifier.json";

impl Classifier {
    /// Learned from the first and last states of the training episodes, turned at random about the vertical, or as an earlier run left
    /// it in `folder`; how well it does on the held-out episodes is written there as `classifier.json`.
    ///
    /// # Errors
    /// An impossible value, an episode without a tool, a fit that fails, a file that cannot be written, or a stop that was asked for.
    pub fn fit(spec: &PointNetSpec, data: &Split, folder: &Path, watch: &Watch) -> anyhow::Result<Self> {
        let tools: Vec<String> = data.tools.keys().cloned().collect();
        ensure!(!tools.is_empty(), "the dataset has no tool that a classifier could choose");
        let example = |episode: &Episode| -> anyhow::Result<Example<usize>> {
            let target = place(&tools, episode)?;
            let (first, last) = ends(episode)?;
            Ok(Example { clouds: Clouds::new(first, last, spec.extent), target })
        };
        let lesson = || {
            let examples = data.train.iter().map(example).collect::<anyhow::Result<Vec<_>>>()?;
            Ok(Some(Lesson { examples, loss: &cross_entropy, turn: std::f64::consts::PI }))
        };
        let net = taught(spec, tools.len(), lesson, folder, watch)?.context("a classifier's lesson is never empty")?;
        let classifier = Self { net, extent: spec.extent, tools };
        if !folder.join(REPORT).exists() {
            let report = classifier.judged(&data.held_out)?;
            write_whole(&folder.join(REPORT), &serde_json::to_vec_pretty(&report)?)?;
        }
        Ok(classifier)
    }

    /// The tools that it tells apart.
    pub fn tools(&self) -> &[String] {
        &self.tools
    }

    /// How probable it is that each of [`Self::tools`] turned `current` into `goal` \[m\].
    pub fn probabilities(&self, current: &[DVec3], goal: &[DVec3]) -> Vec<f64> {
        let row = said(&self.net, &[&Clouds::new(current, goal, self.extent)]);
        log_softmax(&row).into_iter().map(f64::exp).collect()
    }

    /// How well it does on `episodes`.
    ///
    /// # Errors
    /// When one was made with a tool that it does not know.
    pub fn judged(&self, episodes: &[Episode]) -> anyhow::Result<Report> {
        let judge = |episode: &Episode| {
            let (first, last) = ends(episode)?;
            Ok((place(&self.tools, episode)?, self.probabilities(first, last)))
        };
        let judged = episodes.iter().map(judge).collect::<anyhow::Result<Vec<_>>>()?;
        Ok(Report::of(&self.tools, &judged))
    }
}

fn place(tools: &[String], episode: &Episode) -> anyhow::Result<usize> {
    let found = tools.iter().position(|tool| *tool == episode.tool);
    found.with_context(|| format!("an episode was made with the tool \"{}\", of which there is no shape", episode.tool))
}

fn ends(episode: &Episode) -> anyhow::Result<(&[DVec3], &[DVec3])> {
    let ends = episode.states.first().zip(episode.states.last());
    let (first, last) = ends.context("an episode without a state shows no tool")?;
    Ok((&first.positions, &last.positions))
}

/// `−ln p(tool)`, and its derivative by the logits.
fn cross_entropy(logits: &[f32], tool: &usize) -> (f64, Vec<f32>) {
    let log = log_softmax(logits);
    let at = log.iter().enumerate().map(|(k, l)| (l.exp() - f64::from(u8::from(k == *tool))) as f32);
    (-log[*tool], at.collect())
}
