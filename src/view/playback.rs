//! An episode, and what the folder it lies in says of it.
use crate::data::{DatasetSpec, Episode};
use crate::shape;
use crate::state::{Constants, ToolShape};
use anyhow::{Context, bail, ensure};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// An episode file with what is needed to draw it.
#[derive(Clone, Debug)]
pub struct Playback {
    /// Where it was read from.
    pub path: PathBuf,
    /// The episode; its tool's name is empty where its folder does not say it.
    pub episode: Episode,
    /// Shape of its tool; none where its folder does not say it.
    pub shape: Option<Arc<ToolShape>>,
    /// What its pieces are, in their order: the kind of the scene's own material, and the names of what is beside it; none where its
    /// folder does not say it.
    pub pieces: Vec<String>,
}

/// What a dataset's folder says of one of its episodes.
struct Origin {
    tool: String,
    shape: Arc<ToolShape>,
    pieces: Vec<String>,
    constants: Constants,
}

impl Playback {
    /// Reads the episode at `path`; a `dataset.toml` beside it tells its tool and material, and without one it is read alone.
    ///
    /// # Errors
    /// When `path` is a folder, the file is missing or damaged, or `dataset.toml` is damaged or tells of another tool: a sentence
    /// with the file and the fix.
    pub fn open(path: &Path) -> anyhow::Result<Self> {
        if path.is_dir() {
            bail!("{} is a folder; name one file: {}", path.display(), choices(path)?);
        }
        let mut episode = Episode::read(path, "")?;
        let Some(origin) = Origin::of(path)? else {
            // Without parts there is no shape to know.
            let shape = episode.start.is_empty().then(|| Arc::new(ToolShape::from(Vec::new())));
            return Ok(Self { path: path.to_owned(), episode, shape, pieces: Vec::new() });
        };
        let (found, told) = (episode.poses(0).len(), origin.shape.parts.len());
        ensure!(
            found == told,
            "{} has {found} tool parts where the tool `{}` of {SPEC} beside it has {told}; move the file out of that folder",
            path.display(),
            origin.tool
        );
        (episode.tool, episode.constants) = (origin.tool, origin.constants.into());
        Ok(Self { path: path.to_owned(), episode, shape: Some(origin.shape), pieces: origin.pieces })
    }

    /// Median distance of a particle to its nearest neighbour in the first frame \[m\].
    pub(super) fn spacing(&self) -> f64 {
        let distance = shape::spacing(&self.episode.states[0].positions);
        // A lone particle has room around it, and so have those that coincide.
        distance.filter(|distance| *distance > 0.0).unwrap_or(0.01)
    }
}

const SPEC: &str = "dataset.toml";

impl Origin {
    fn of(path: &Path) -> anyhow::Result<Option<Self>> {
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let number: Option<usize> = stem.strip_prefix("episode_").and_then(|n| n.parse().ok());
        let file = path.with_file_name(SPEC);
        let (Some(number), true) = (number, file.exists()) else { return Ok(None) };
        let text = std::fs::read_to_string(&file).with_context(|| format!("cannot read {}", file.display()))?;
        let alone = "copy the episode into a folder of its own to view it without its tool's shape";
        let spec: DatasetSpec = toml_edit::de::from_str(&text)
            .with_context(|| format!("{} is not a dataset's spec; {alone}", file.display()))?;
        ensure!(!spec.tool.is_empty(), "{} names no tool; {alone}", file.display());
        let (tool, part) = spec.tool.get_index(number % spec.tool.len()).expect("a number below their count");
        let built = part.clone().build();
        let built =
            built.with_context(|| format!("the tool `{tool}` of {} cannot be built; {alone}", file.display()))?;
        let scene = spec.scene_of(number).with_context(|| format!("in {}; {alone}", file.display()))?;
        let material = serde_json::to_value(&scene.material).ok();
        let material = material.and_then(|m| Some(m.get("kind")?.as_str()?.to_owned()));
        let pieces = material.into_iter().chain(scene.beside.into_keys()).collect();
        let constants = spec.constants_of(number);
        Ok(Some(Self { tool: tool.clone(), shape: built.shape().clone(), pieces, constants }))
    }
}

/// The `.npz` files of a folder, the middle ones left out where there are many.
fn choices(folder: &Path) -> anyhow::Result<String> {
    const SHOWN: usize = 6;
    let entries = std::fs::read_dir(folder).with_context(|| format!("cannot list {}", folder.display()))?;
    let paths = entries.flatten().map(|entry| entry.path()).filter(|p| p.extension().is_some_and(|x| x == "npz"));
    let mut names: Vec<String> = paths.filter_map(|p| Some(p.file_name()?.to_string_lossy().into_owned())).collect();
    names.sort();
    Ok(match names.len() {
        0 => "it holds no .npz, so simulate into it first".to_owned(),
        count if count <= SHOWN => names.join(", "),
        count => format!("{} … {} ({count} files)", names[..SHOWN - 1].join(", "), names[count - 1]),
    })
}
