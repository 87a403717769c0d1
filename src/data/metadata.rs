//! What a dataset says of itself: LagrangeBench's keys where it has one, and ours.
use super::dataset::{DatasetSpec, SPEC, episode_path};
use super::split::{HELD_OUT, Part, SplitSpec};
use super::{Episode, Statistics};
use crate::config::write_whole;
use crate::shape::spacing;
use anyhow::Context;
use indexmap::IndexMap;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// `metadata.json`; the keys down to `default_connectivity_radius` and the statistics mean what they mean in LagrangeBench (Toshev et al. 2023).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Metadata {
    /// What was simulated.
    pub case: String,
    /// By what.
    pub solver: String,
    /// Space dimensions.
    pub dim: usize,
    /// Median distance of a particle to its nearest neighbour at the start of the first episode \[m\].
    pub dx: f64,
    /// Time between frames, the control interval \[s\].
    pub dt: f64,
    /// Duration of an episode \[s\].
    pub t_end: f64,
    /// Frames are kept every so many `dt`.
    pub write_every: usize,
    /// Steps of a trajectory to learn from.
    pub sequence_length_train: usize,
    /// Number of trajectories to learn from when a fifth is held out.
    pub num_trajs_train: usize,
    /// Steps of a held-out trajectory.
    pub sequence_length_test: usize,
    /// Number of held-out trajectories.
    pub num_trajs_test: usize,
    /// Greatest number of particles in an episode.
    pub num_particles_max: usize,
    /// Whether space repeats along each axis: never.
    pub periodic_boundary_conditions: [bool; 3],
    /// Least and greatest position along each axis \[m\].
    pub bounds: [[f64; 2]; 3],
    /// One and a half `dx` \[m\].
    pub default_connectivity_radius: f64,
    /// Of all episodes.
    #[serde(flatten)]
    pub statistics: Statistics,
    /// Every episode's file and tool.
    pub episodes: Vec<Entry>,
    /// Which episodes are held out.
    #[serde(default, skip_serializing_if = "SplitSpec::is_default")]
    pub split: SplitSpec,
    /// Seed of the dataset; recordings have none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// The spec that made it, or where recordings were imported from.
    pub spec: serde_json::Value,
}

/// One episode in [`Metadata`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Entry {
    /// File name in the folder.
    pub file: String,
    /// Name of the tool.
    pub tool: String,
    /// The action θ.
    pub theta: Vec<f64>,
    /// Name of the material, where the dataset lists several.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
    /// Name of the start, where the dataset lists several.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start: Option<String>,
    /// What `vary` drew for it.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub constants: IndexMap<String, f64>,
    /// What a recording says it is for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub part: Option<Part>,
}

impl Entry {
    /// Of episode `k`, which says no more than its tool and action.
    pub(super) fn of(k: usize, episode: &Episode) -> Self {
        Self {
            file: episode_path(Path::new(""), k).to_string_lossy().into_owned(),
            tool: episode.tool.clone(),
            theta: episode.theta.clone(),
            material: None,
            start: None,
            constants: IndexMap::new(),
            part: None,
        }
    }
}

/// What episodes do not show of where they come from.
struct Source {
    case: String,
    solver: String,
    split: SplitSpec,
    seed: Option<u64>,
    spec: serde_json::Value,
}

impl Metadata {
    pub(super) const FILE: &str = "metadata.json";

    /// Describes all `episodes` that `spec` asks for.
    pub(super) fn describe(spec: &DatasetSpec, episodes: &[Episode]) -> anyhow::Result<Self> {
        let name = |named: Option<&str>| named.map(str::to_owned);
        let entry = |(k, e): (usize, &Episode)| Entry {
            material: name(spec.material_of(k).map(|(name, _)| name)),
            start: name(spec.start_of(k).map(|(name, _)| name)),
            constants: spec.constants_of(k),
            ..Entry::of(k, e)
        };
        let source = Source {
            case: "pliant".into(),
            solver: "rapier3d".into(),
            split: spec.split.clone(),
            seed: Some(spec.seed),
            spec: serde_json::to_value(spec).context("the dataset's spec cannot be written as JSON")?,
        };
        Self::measured(source, episodes.iter().enumerate().map(entry).collect(), episodes)
    }

    /// Describes recordings.
    ///
    /// # Errors
    /// Never; simulated data share the way.
    pub(super) fn recorded(
        case: &str,
        origin: serde_json::Value,
        split: SplitSpec,
        entries: Vec<Entry>,
        episodes: &[Episode],
    ) -> anyhow::Result<Self> {
        let source = Source { case: case.into(), solver: "imported".into(), split, seed: None, spec: origin };
        Self::measured(source, entries, episodes)
    }

    /// The same folder described anew from its spec, if it has one, and its episodes.
    pub(super) fn again(&self, spec: Option<&DatasetSpec>, episodes: &[Episode]) -> anyhow::Result<Self> {
        let Some(spec) = spec else {
            let Self { case, solver, split, seed, spec, episodes: entries, .. } = self.clone();
            return Self::measured(Source { case, solver, split, seed, spec }, entries, episodes);
        };
        Self::describe(spec, episodes)
    }

    /// What `source` says and what `episodes` show.
    fn measured(source: Source, entries: Vec<Entry>, episodes: &[Episode]) -> anyhow::Result<Self> {
        let split = source.split.clone().build()?;
        let held = split.held_out(episodes, &entries, HELD_OUT).into_iter().filter(|h| *h).count();
        let (dx, dt) = (spacing(&episodes[0].states[0].positions).unwrap_or_default(), episodes[0].interval);
        let steps = episodes.iter().map(Episode::horizon).min().unwrap_or_default();
        Ok(Self {
            case: source.case,
            solver: source.solver,
            dim: 3,
            dx,
            dt,
            t_end: dt * steps as f64,
            write_every: 1,
            sequence_length_train: steps,
            num_trajs_train: episodes.len() - held,
            sequence_length_test: steps,
            num_trajs_test: held,
            num_particles_max: episodes.iter().map(|e| e.states[0].len()).max().unwrap_or_default(),
            periodic_boundary_conditions: [false; 3],
            bounds: Self::bounds(episodes),
            default_connectivity_radius: 1.5 * dx,
            statistics: Statistics::of(episodes),
            episodes: entries,
            split: source.split,
            seed: source.seed,
            spec: source.spec,
        })
    }

    /// Least and greatest position along each axis \[m\]; zeros of no episodes.
    pub(super) fn bounds(episodes: &[Episode]) -> [[f64; 2]; 3] {
        let mut points = episodes.iter().flat_map(|e| &e.states).flat_map(|x| &x.positions);
        let first = points.next().copied().unwrap_or_default();
        let (low, high) = points.fold((first, first), |(low, high), p| (low.min(*p), high.max(*p)));
        std::array::from_fn(|i| [low[i], high[i]])
    }

    /// For each of `episodes`, which are this dataset's, whether it is held out.
    pub(super) fn held_out(&self, episodes: &[Episode], fraction: f64) -> Vec<bool> {
        let split = self.split.clone().build().expect("a split has nothing to build that could fail");
        split.held_out(episodes, &self.episodes, fraction)
    }

    /// Whether the episodes were recorded elsewhere.
    pub(super) fn is_imported(&self) -> bool {
        self.seed.is_none()
    }

    /// Names of the files that the dataset consists of, this one included.
    pub(super) fn files(&self) -> Vec<String> {
        let spec = (!self.is_imported()).then(|| SPEC.to_owned());
        spec.into_iter().chain([Self::FILE.to_owned()]).chain(self.episodes.iter().map(|e| e.file.clone())).collect()
    }

    /// Writes `metadata.json` into `folder`, whole.
    pub(super) fn write(&self, folder: &Path) -> anyhow::Result<()> {
        let mut text = serde_json::to_string_pretty(self).context("the metadata cannot be written as JSON")?;
        text.push('\n');
        write_whole(&folder.join(Self::FILE), text.as_bytes())
    }

    /// Reads `metadata.json` of a finished dataset.
    pub(super) fn read(folder: &Path) -> anyhow::Result<Self> {
        let path = folder.join(Self::FILE);
        let text = std::fs::read_to_string(&path).with_context(|| {
            format!(
                "{} is missing: the dataset is not finished; simulate again, it goes on where it stopped",
                path.display()
            )
        })?;
        serde_json::from_str(&text)
            .with_context(|| format!("{} is damaged; remove it and simulate again", path.display()))
    }
}
