//! All windows of some episodes: what batches are drawn from, and what models are judged on.
use super::Window;
use super::split::Tools;
use super::spread::spread;
use crate::data::Episode;
use crate::state::{Particles, ToolShape};
use anyhow::Context;
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use std::sync::Arc;

/// All windows of one length over some episodes, and which of them show motion.
pub struct Windows<'a> {
    episodes: Vec<(&'a Episode, &'a Arc<ToolShape>)>,
    all: Vec<(usize, usize)>,
    moving: Vec<(usize, usize)>,
    length: usize,
}

impl<'a> Windows<'a> {
    /// Windows of `length` steps; one is moving when some particle goes further than `motion` \[m\] in one of its steps.
    ///
    /// # Errors
    /// A sentence naming the episode that is too short, incomplete, not finite, or whose tool is not in `tools`.
    pub fn new(
        episodes: impl IntoIterator<Item = &'a Episode>,
        tools: &'a Tools,
        length: usize,
        motion: f64,
    ) -> anyhow::Result<Self> {
        let mut windows = Self { episodes: Vec::new(), all: Vec::new(), moving: Vec::new(), length };
        for (e, episode) in episodes.into_iter().enumerate() {
            let steps = check(episode, length).with_context(|| format!("episode {e} of the data cannot be used"))?;
            let shape = tools.get(&episode.tool).with_context(|| {
                format!("episode {e} was made with the tool \"{}\", of which there is no shape", episode.tool)
            })?;
            windows.episodes.push((episode, shape));
            let moves: Vec<bool> = episode.states.windows(2).map(|pair| shifts(pair).any(|d| d > motion)).collect();
            for start in 0..=steps - length {
                windows.all.push((e, start));
                if moves[start..start + length].contains(&true) {
                    windows.moving.push((e, start));
                }
            }
        }
        Ok(windows)
    }

    /// Number of windows.
    pub fn len(&self) -> usize {
        self.all.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// Windows of every episode in turn, from its first step to its last.
    pub fn iter(&self) -> impl Iterator<Item = Window<'a>> + '_ {
        self.all.iter().map(|at| self.window(*at))
    }

    /// Draws a window: with probability `moving` one in which something moves, else any. Returns its episode too.
    pub fn draw(&self, moving: f64, rng: &mut ChaCha8Rng) -> (usize, Window<'a>) {
        let list = if rng.random::<f64>() < moving && !self.moving.is_empty() { &self.moving } else { &self.all };
        let at = list[rng.random_range(0..list.len())];
        (at.0, self.window(at))
    }

    /// `count` different windows (or all there are) at even distances through the list of all, in its order.
    pub fn spread(&self, count: usize) -> Vec<Window<'a>> {
        self.evenly(&self.all, count)
    }

    /// `count` different windows in which something moves (or all there are) at even distances, in order.
    pub fn spread_moving(&self, count: usize) -> Vec<Window<'a>> {
        self.evenly(&self.moving, count)
    }

    fn evenly(&self, list: &[(usize, usize)], count: usize) -> Vec<Window<'a>> {
        spread(count, list.len()).map(|i| self.window(list[i])).collect()
    }

    fn window(&self, (episode, start): (usize, usize)) -> Window<'a> {
        let (episode, shape) = self.episodes[episode];
        Window::of(episode, start, self.length, shape)
    }
}

/// How far each particle goes between two states \[m\].
pub(super) fn shifts(pair: &[Particles]) -> impl Iterator<Item = f64> + '_ {
    pair[0].positions.iter().zip(&pair[1].positions).map(|(a, b)| a.distance(*b))
}

fn check(episode: &Episode, length: usize) -> anyhow::Result<usize> {
    let (steps, states) = (episode.controls.len(), episode.states.len());
    anyhow::ensure!(states == steps + 1, "it has {states} states and {steps} controls, one more state is needed");
    anyhow::ensure!(steps >= length, "it has {steps} control steps, fewer than the {length} of a window");
    let count = episode.states[0].len();
    for (t, state) in episode.states.iter().enumerate() {
        anyhow::ensure!(
            state.len() == count && state.velocities.len() == count,
            "its step {t} has not {count} particles"
        );
        anyhow::ensure!(state.is_finite(), "its step {t} contains a number that is not finite");
    }
    Ok(steps)
}

#[cfg(test)]
mod tests {
    use super::super::window::tests::{episode, tools};
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn a_window_starts_where_the_tool_stands_and_ends_with_its_last_target() {
        let (episode, tools) = (episode(), tools());
        let list = [episode];
        let windows = Windows::new(&list, &tools, 2, 1e-3).unwrap();
        assert_eq!(windows.len(), 5);
        for (t, window) in windows.iter().enumerate() {
            assert_eq!(window.scene.poses[0].translation.z, t as f64);
            assert_eq!(window.controls[1].poses[0].translation.z, t as f64 + 2.0);
            assert_eq!(*window.targets, list[0].states[t + 1..t + 3]);
        }
    }

    #[test]
    fn only_windows_in_which_something_moves_are_preferred() {
        let (list, tools) = ([episode()], tools());
        let windows = Windows::new(&list, &tools, 2, 1e-3).unwrap();
        assert_eq!(windows.moving, [(0, 1), (0, 2), (0, 3)]);
        assert_eq!(windows.spread_moving(9).len(), 3);
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut at_rest = |moving: f64| {
            let moves = |w: &Window<'_>| w.scene.particles.positions[2] != w.targets[1].positions[2];
            (0..2000).filter(|_| !moves(&windows.draw(moving, &mut rng).1)).count()
        };
        assert_eq!(at_rest(1.0), 0);
        let rare = at_rest(0.5);
        assert!((300..500).contains(&rare), "2 of 5 windows rest, half of the draws are preferred: {rare} of 2000");
    }
}
