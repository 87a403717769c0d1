//! Which episodes are held out: whole episodes, never single frames, evenly spread within each tool.
use super::{Dataset, Episode};
use indexmap::IndexMap;

/// Fraction of a dataset's episodes that no fit sees.
pub const HELD_OUT: f64 = 0.2;

impl Dataset {
    /// `(to learn from, held out)`: of each tool's n episodes, every (1/`fraction`)-th is held out, ⌈`fraction` · n⌉ in all
    /// but at most n − 1. The same episodes every time.
    pub fn split(&self, fraction: f64) -> (Vec<&Episode>, Vec<&Episode>) {
        let held = held_out(self.episodes.iter().map(|e| &e.tool[..]), fraction);
        let pick =
            |wanted: bool| self.episodes.iter().zip(&held).filter(|(_, h)| **h == wanted).map(|(e, _)| e).collect();
        (pick(false), pick(true))
    }
}

/// For each episode, given by its tool, whether it is held out.
pub(super) fn held_out<'a>(tools: impl Iterator<Item = &'a str> + Clone, fraction: f64) -> Vec<bool> {
    let mut sizes: IndexMap<&str, usize> = IndexMap::new();
    for tool in tools.clone() {
        *sizes.entry(tool).or_default() += 1;
    }
    let mut seen: IndexMap<&str, usize> = IndexMap::new();
    tools
        .map(|tool| {
            let (n, i) = (sizes[tool], seen.entry(tool).or_default());
            let count = ((fraction.clamp(0.0, 1.0) * n as f64 - 1e-9).ceil() as usize).min(n - 1);
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
        let held = held_out(tools(45), 0.2);
        for tool in 0..3 {
            let mine: Vec<usize> = (0..15).filter(|i| held[3 * i + tool]).collect();
            assert_eq!(mine, [4, 9, 14], "tool {tool}");
        }
        let count = |n, fraction| held_out(tools(n), fraction).into_iter().filter(|h| *h).count();
        assert_eq!([count(6, 0.2), count(3, 0.2), count(45, 0.0), count(6, 1.0), count(0, 0.5)], [3, 0, 0, 3, 0]);
    }
}
