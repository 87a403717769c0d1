//! Held out evenly: of each tool's episodes every so-many-th.
use super::{Entry, Episode, HoldOut, share};
use indexmap::IndexMap;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Of each tool's n episodes, ⌈fraction · n⌉ evenly spread ones are held out, at most n − 1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EpisodeSpec {}

impl EpisodeSpec {
    /// Nothing to check.
    ///
    /// # Errors
    /// Never.
    pub fn build(self) -> anyhow::Result<impl HoldOut> {
        Ok(self)
    }
}

impl HoldOut for EpisodeSpec {
    fn held_out(&self, _: &[Episode], entries: &[Entry], fraction: f64) -> Vec<bool> {
        evenly(entries.iter().map(|e| &e.tool[..]), fraction)
    }
}

/// For each episode, given by its tool, whether it is held out.
fn evenly<'a>(tools: impl Iterator<Item = &'a str> + Clone, fraction: f64) -> Vec<bool> {
    let mut sizes: IndexMap<&str, usize> = IndexMap::new();
    for tool in tools.clone() {
        *sizes.entry(tool).or_default() += 1;
    }
    let mut seen: IndexMap<&str, usize> = IndexMap::new();
    tools
        .map(|tool| {
            let (n, i) = (sizes[tool], seen.entry(tool).or_default());
            let count = share(fraction, n);
            *i += 1;
            *i * count / n > (*i - 1) * count / n
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_tool_gives_its_fraction_evenly_and_keeps_an_episode() {
        let tools = |n: usize| (0..n).map(|k| ["grip", "press", "roll"][k % 3]);
        let held = evenly(tools(45), 0.2);
        for tool in 0..3 {
            let mine: Vec<usize> = (0..15).filter(|i| held[3 * i + tool]).collect();
            assert_eq!(mine, [4, 9, 14], "tool {tool}");
        }
        let count = |n, fraction| evenly(tools(n), fraction).into_iter().filter(|h| *h).count();
        assert_eq!([count(6, 0.2), count(3, 0.2), count(45, 0.0), count(6, 1.0), count(0, 0.5)], [3, 0, 0, 3, 0]);
    }
}
