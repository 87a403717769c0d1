//! Datasets in the layouts of other frameworks.
mod gns;
#[cfg(feature = "hdf5")]
mod lagrangebench;
mod pickle;

use super::contents::Contents;
use super::split::HELD_OUT;
use super::{Episode, Metadata};
use crate::config::{same_place, write_whole};
use crate::state::ToolShape;
use anyhow::{Context, ensure};
use gns::GnsNpz;
use serde_json::Value as Json;
use std::path::Path;

/// A layout that another framework reads.
pub trait Layout: Sync {
    /// Its name on the command line.
    fn name(&self) -> &'static str;

    /// Ending of its files of trajectories, without the dot.
    fn ending(&self) -> &'static str;

    /// Type number of the particles of body number `body`, free ones in that framework.
    fn free(&self, body: u32) -> i64;

    /// Type number of particles whose motion is given.
    fn driven(&self) -> i64;

    /// A file of trajectories.
    ///
    /// # Errors
    /// When they do not fit the format.
    fn bytes(&self, trajectories: &[Trajectory]) -> anyhow::Result<Vec<u8>>;

    /// What goes into `metadata.json`, of a dataset whose largest trajectory has `most` particles.
    fn metadata(&self, metadata: &Metadata, most: usize) -> Json;
}

/// The layouts that can be exported to.
pub const LAYOUTS: &[&dyn Layout] = &[
    &GnsNpz,
    #[cfg(feature = "hdf5")]
    &lagrangebench::LagrangebenchH5,
];

/// One episode as other frameworks see it: the tool is particles whose motion is given.
pub struct Trajectory {
    /// Positions \[m\], frames × particles × 3, row by row; the object's particles come first, then the tool's.
    pub positions: Vec<f32>,
    /// Number of frames.
    pub frames: usize,
    /// Type number of each particle.
    pub types: Vec<i64>,
}

/// Type numbers that both GNS and LagrangeBench have room for.
const TYPES: i64 = 9;

/// Writes the dataset in `folder` to `out`, in `layout`: files `train`, `valid` and `test` and a `metadata.json`.
///
/// The training episodes are Pliant's own; of those held out every other one is in `test`, the rest in `valid`. Returns how many
/// are in each.
///
/// # Errors
/// When the dataset does not read, has more bodies than the layout has types, or `out` cannot be written to or is `folder`.
pub fn export(folder: &Path, layout: &dyn Layout, out: &Path) -> anyhow::Result<[(&'static str, usize); 3]> {
    let contents = Contents::read(folder)?;
    let episodes = contents.attempt(folder).into_iter().collect::<anyhow::Result<Vec<Episode>>>()?;
    let tools = contents.tools(folder)?;
    ensure!(!same_place(folder, out), "{} is the dataset itself; export to another folder", out.display());
    let mut parts = [("train", Vec::new()), ("valid", Vec::new()), ("test", Vec::new())];
    let (mut judged, mut most) = (0, 0);
    for (episode, held) in episodes.iter().zip(contents.metadata.held_out(&episodes, HELD_OUT)) {
        let trajectory = Trajectory::of(episode, &tools[&episode.tool], layout)?;
        most = most.max(trajectory.types.len());
        let part = if !held { 0 } else { 2 - judged % 2 };
        judged += usize::from(held);
        parts[part].1.push(trajectory);
    }
    for (name, trajectories) in &parts {
        let path = out.join(format!("{name}.{}", layout.ending()));
        let bytes = layout.bytes(trajectories).with_context(|| format!("{} cannot be prepared", path.display()))?;
        write_whole(&path, &bytes)?;
    }
    let text = serde_json::to_string_pretty(&layout.metadata(&contents.metadata, most))? + "\n";
    write_whole(&out.join(Metadata::FILE), text.as_bytes())?;
    Ok(parts.map(|(name, trajectories)| (name, trajectories.len())))
}

impl Trajectory {
    fn of(episode: &Episode, tool: &ToolShape, layout: &dyn Layout) -> anyhow::Result<Self> {
        let mut types: Vec<i64> = episode.body.iter().map(|body| layout.free(*body)).collect();
        ensure!(
            types.iter().all(|t| (0..TYPES).contains(t)),
            "body {} has no type in {}, which has {TYPES}",
            episode.body.iter().max().copied().unwrap_or_default(),
            layout.name()
        );
        types.resize(types.len() + tool.parts.iter().map(|part| part.surface.len()).sum::<usize>(), layout.driven());
        let frame = |t: usize| episode.states[t].positions.iter().copied().chain(tool.surface_at(episode.poses(t)));
        let frames = episode.horizon() + 1;
        let positions = (0..frames).flat_map(frame).flat_map(|p| p.as_vec3().to_array()).collect();
        Ok(Self { positions, frames, types })
    }
}
