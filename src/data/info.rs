//! What a folder of episodes holds, in numbers.
use super::contents::Contents;
use super::{Episode, Histogram, Metadata, SplitSpec, Statistics};
use indexmap::IndexMap;
use serde::Serialize;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Counts, ranges and scales of a dataset.
#[derive(Clone, Debug, Serialize)]
pub struct Info {
    /// The folder.
    pub folder: PathBuf,
    /// What made the episodes.
    pub solver: String,
    /// Number of episodes that read.
    pub episodes: usize,
    /// A sentence for each episode that does not: a file that is missing or damaged, a number that is not finite.
    pub unreadable: Vec<String>,
    /// Least and greatest number of control steps in an episode.
    pub steps: [usize; 2],
    /// Least and greatest number of particles in an episode.
    pub particles: [usize; 2],
    /// Duration of a control step \[s\].
    pub interval: f64,
    /// Recorded time of all episodes \[min\]; of simulated ones the time that the robot moves.
    pub minutes: f64,
    /// What each tool did, by name.
    pub tools: IndexMap<String, Usage>,
    /// Number of episodes with each material, where the dataset lists several.
    #[serde(skip_serializing_if = "IndexMap::is_empty")]
    pub materials: IndexMap<String, usize>,
    /// Number of episodes with each start, where the dataset lists several.
    #[serde(skip_serializing_if = "IndexMap::is_empty")]
    pub starts: IndexMap<String, usize>,
    /// Least and greatest position along each axis \[m\].
    pub bounds: [[f64; 2]; 3],
    /// Scales of the motion in all episodes.
    pub statistics: Statistics,
    /// How far particles go in a step.
    pub displacement: Histogram,
    /// By what rule episodes are held out.
    pub split: SplitSpec,
    /// Number of episodes to learn from.
    pub train: usize,
    /// Number of episodes held out.
    pub held_out: usize,
}

/// What one tool did in a dataset.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Usage {
    /// Number of its episodes.
    pub episodes: usize,
    /// Their duration \[min\].
    pub minutes: f64,
    /// Least and greatest value of each coordinate of θ.
    pub theta: Vec<[f64; 2]>,
}

impl Info {
    /// Of the dataset in `folder`.
    ///
    /// # Errors
    /// When the folder holds no dataset or an unfinished one; episodes that do not read are listed instead.
    pub fn of(folder: &Path) -> anyhow::Result<Self> {
        let contents = Contents::read(folder)?;
        let (mut episodes, mut unreadable) = (Vec::new(), Vec::new());
        let (mut materials, mut starts) = (IndexMap::new(), IndexMap::new());
        for (entry, read) in contents.metadata.episodes.iter().zip(contents.attempt(folder)) {
            match read {
                Ok(episode) => {
                    episodes.push(episode);
                    entry.material.iter().for_each(|name| *materials.entry(name.clone()).or_default() += 1);
                    entry.start.iter().for_each(|name| *starts.entry(name.clone()).or_default() += 1);
                }
                Err(error) => unreadable.push(format!("{error:#}")),
            }
        }
        let Metadata { solver, split, num_trajs_train, num_trajs_test, dt, .. } = contents.metadata;
        let mut tools: IndexMap<String, Usage> = IndexMap::new();
        episodes.iter().for_each(|e| tools.entry(e.tool.clone()).or_default().count(e));
        Ok(Self {
            folder: folder.to_owned(),
            solver,
            steps: range(episodes.iter().map(Episode::horizon)),
            particles: range(episodes.iter().map(|e| e.states[0].len())),
            interval: dt,
            minutes: tools.values().map(|t| t.minutes).sum(),
            tools,
            materials,
            starts,
            split,
            bounds: Metadata::bounds(&episodes),
            statistics: Statistics::of(&episodes),
            displacement: Histogram::of(&episodes),
            train: num_trajs_train,
            held_out: num_trajs_test,
            episodes: episodes.len(),
            unreadable,
        })
    }

    /// A page for a terminal.
    pub fn to_text(&self) -> String {
        let mut text = String::new();
        let total = self.episodes + self.unreadable.len();
        let mut line = |name: &str, value: String| {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{name:<12} {value}");
        };
        let millimetres = |values: [f64; 3]| values.map(|v| format!("{:.4}", 1e3 * v)).join("  ");
        line("folder", self.folder.display().to_string());
        line("made by", self.solver.clone());
        line("episodes", format!("{total}: {} to learn from, {} held out", self.train, self.held_out));
        line("steps", format!("{} of {:.4} s", between(self.steps), self.interval));
        line("particles", between(self.particles));
        line("time", format!("{:.1} min", self.minutes));
        for (name, tool) in &self.tools {
            let theta: Vec<String> = tool.theta.iter().map(|[a, b]| format!("[{a:.4}, {b:.4}]")).collect();
            line(
                "tool",
                format!(
                    "{name}: {} episodes, {:.1} min, θ in {}",
                    tool.episodes,
                    tool.minutes,
                    match &theta[..] {
                        [] => "nothing".to_owned(),
                        _ => theta.join(" × "),
                    }
                ),
            );
        }
        for (name, count) in &self.materials {
            line("material", format!("{name}: {count} episodes"));
        }
        for (name, count) in &self.starts {
            line("start", format!("{name}: {count} episodes"));
        }
        for (axis, [low, high]) in ["x", "y", "z"].iter().zip(self.bounds) {
            line(axis, format!("{low:.4} to {high:.4} m"));
        }
        let scales = &self.statistics;
        line("per step", "       x       y       z [mm]".to_owned());
        line("  mean", millimetres(scales.vel_mean));
        line("  std", millimetres(scales.vel_std));
        line("  Δ mean", millimetres(scales.acc_mean));
        line("  Δ std", millimetres(scales.acc_std));
        line("  moving", format!("{:.4} root mean square of what moves more than 0.01", 1e3 * scales.displacement));
        line("unreadable", self.unreadable.len().to_string());
        text + &self.unreadable.iter().map(|sentence| format!("  {sentence}\n")).collect::<String>()
            + "displacement per step [mm]\n"
            + &self.displacement.to_text()
    }
}

impl Usage {
    fn count(&mut self, episode: &Episode) {
        self.episodes += 1;
        self.minutes += episode.horizon() as f64 * episode.interval / 60.0;
        for (i, theta) in episode.theta.iter().enumerate() {
            match self.theta.get_mut(i) {
                Some([low, high]) => (*low, *high) = (low.min(*theta), high.max(*theta)),
                None => self.theta.push([*theta; 2]),
            }
        }
    }
}

/// Least and greatest of some numbers; zeros of none.
fn range(values: impl Iterator<Item = usize> + Clone) -> [usize; 2] {
    [values.clone().min().unwrap_or_default(), values.max().unwrap_or_default()]
}

fn between([low, high]: [usize; 2]) -> String {
    if low == high { low.to_string() } else { format!("{low} to {high}") }
}
