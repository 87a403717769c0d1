//! Constants of a scene that are drawn anew for every episode.
use crate::state::{Constants, stream};
use crate::world::SceneSpec;
use anyhow::{Context, ensure};
use indexmap::IndexMap;
use rand::Rng;
use serde_json::Value;

/// Ranges by the constant's path in the scene, such as `material.young_modulus`; a count is drawn as a whole number.
pub type Ranges = IndexMap<String, [f64; 2]>;

/// What the ranges give in episode `k` of a dataset with this seed, each uniformly from its range.
pub(super) fn drawn(ranges: &Ranges, seed: u64, k: usize) -> Constants {
    let mut rng = stream(seed, &[u64::from_le_bytes(*b"constant"), k as u64]);
    ranges.iter().map(|(path, [low, high])| (path.clone(), low + (high - low) * rng.random::<f64>())).collect()
}

/// What `scene` has in the places of the ranges.
pub(super) fn own(ranges: &Ranges, scene: &SceneSpec) -> Constants {
    let mut tree = serde_json::to_value(scene).unwrap_or_default();
    let found = |path: &String| Some((path.clone(), number(&mut tree, path)?.as_f64()?));
    ranges.keys().filter_map(found).collect()
}

/// The place of a constant in a scene.
fn number<'a>(tree: &'a mut Value, path: &str) -> Option<&'a mut Value> {
    let found = path.split('.').try_fold(tree, |below, key| match below {
        Value::Array(items) => key.parse::<usize>().ok().and_then(|i| items.get_mut(i)),
        other => other.get_mut(key),
    });
    found.filter(|found| found.is_number())
}

/// The scene with these constants.
///
/// # Errors
/// When the scene has no such number: a sentence with the path.
pub(super) fn with(scene: SceneSpec, constants: &Constants) -> anyhow::Result<SceneSpec> {
    if constants.is_empty() {
        return Ok(scene);
    }
    let mut tree = serde_json::to_value(scene).context("the scene cannot be written as JSON")?;
    for (path, value) in constants {
        let number = number(&mut tree, path);
        let number = number.with_context(|| format!("`vary` names scene.{path}, which is no number of this scene"))?;
        *number = if number.is_f64() { (*value).into() } else { (value.round() as u64).into() };
    }
    serde_json::from_value(tree).context("the scene with its constants from `vary` is impossible")
}

/// Refuses ranges that are none, or whose path leads to no number of `scene`.
///
/// # Errors
/// A sentence naming the path.
pub(super) fn check(ranges: &Ranges, scene: &SceneSpec) -> anyhow::Result<()> {
    for (path, [low, high]) in ranges {
        ensure!(
            low <= high && (high - low).is_finite(),
            "`vary` gives scene.{path} the range [{low}, {high}]; it must be [low, high] with low ≤ high"
        );
    }
    let lowest = ranges.iter().map(|(path, [low, _])| (path.clone(), *low)).collect();
    with(scene.clone(), &lowest).map(|_| ())
}
