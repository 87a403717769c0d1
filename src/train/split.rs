//! What a fit is given: episodes to learn from, episodes to be judged on, and the shapes of the tools in them.
use crate::data::{Dataset, Episode};
use crate::state::ToolShape;
use indexmap::IndexMap;
use std::sync::Arc;

/// Shapes of tools by name.
pub type Tools = IndexMap<String, Arc<ToolShape>>;

/// Episodes for fitting and for judging; nothing in `held_out` ever influences a fit.
#[derive(Clone, Debug, Default)]
pub struct Split {
    /// Episodes to fit to.
    pub train: Vec<Episode>,
    /// Episodes to judge by.
    pub held_out: Vec<Episode>,
    /// Shape of every tool that occurs in them.
    pub tools: Tools,
}

impl Split {
    /// The episodes of `dataset`, `fraction` of each tool's held out as [`Dataset::split`] chooses them.
    pub fn of(dataset: &Dataset, fraction: f64) -> Self {
        let (train, held_out) = dataset.split(fraction);
        let own = |episodes: Vec<&Episode>| episodes.into_iter().cloned().collect();
        Self { train: own(train), held_out: own(held_out), tools: dataset.tools.clone() }
    }
}

/// Sets a fraction of `episodes` aside, the last ones of every tool: `(to fit to, to choose weights by)`.
///
/// Every tool with at least two episodes gives at least one when `fraction` > 0, and keeps at least one.
pub(super) fn set_aside(episodes: &[Episode], fraction: f64) -> (Vec<&Episode>, Vec<&Episode>) {
    let mut by_tool: IndexMap<&str, Vec<usize>> = IndexMap::new();
    for (i, episode) in episodes.iter().enumerate() {
        by_tool.entry(&episode.tool).or_default().push(i);
    }
    let mut aside = vec![false; episodes.len()];
    for of_tool in by_tool.values() {
        let count = (fraction * of_tool.len() as f64).ceil() as usize;
        for i in of_tool.iter().rev().take(count.min(of_tool.len() - 1)) {
            aside[*i] = true;
        }
    }
    let pick = |wanted: bool| episodes.iter().zip(&aside).filter(|(_, a)| **a == wanted).map(|(e, _)| e).collect();
    (pick(false), pick(true))
}
