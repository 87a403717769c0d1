//! Which keys name parts, and the files that parts stand in.
use super::error::ConfigError;
use super::source::{Place, Sources};
use super::suggest::{enumerate, nearest};
use super::tree::{Entry, Node, Table, Value};
use std::path::{Component, Path, PathBuf};

/// The folders of the configs root: a key of the same name takes a part's file stem for a value.
#[derive(Clone, Debug)]
pub(super) struct Groups {
    root: PathBuf,
    names: Vec<String>,
}

impl Groups {
    /// The folders in the nearest ancestor of `file` that is called `configs`, or else in `./configs`.
    pub(super) fn around(file: &Path) -> Self {
        let absolute = std::path::absolute(file).unwrap_or_else(|_| file.to_owned());
        let above =
            absolute.ancestors().skip(1).find(|folder| folder.file_name().is_some_and(|name| name == "configs"));
        let root = above.map_or_else(|| PathBuf::from("configs"), shown);
        let folders = std::fs::read_dir(&root).into_iter().flatten().flatten().filter(|entry| entry.path().is_dir());
        let mut names: Vec<String> = folders.filter_map(|entry| entry.file_name().into_string().ok()).collect();
        names.sort_unstable();
        Self { root, names }
    }

    /// Whether a key of this name takes parts.
    pub(super) fn has(&self, key: &str) -> bool {
        self.names.iter().any(|name| name == key)
    }

    /// The folder that the parts of a key stand in.
    pub(super) fn folder(&self, key: &str) -> PathBuf {
        self.root.join(key)
    }
}

/// The file that `name` (a stem in `folder`, or a path relative to it) stands for.
///
/// # Errors
/// There is none: the nearest name and all names are listed, at the place where the name is used.
pub(super) fn locate(
    folder: &Path,
    name: &str,
    used: Option<Place>,
    sources: &Sources,
) -> Result<PathBuf, ConfigError> {
    let suffix = if name.ends_with(".toml") { "" } else { ".toml" };
    let path = shown(&folder.join(format!("{name}{suffix}")));
    if path.is_file() {
        return Ok(path);
    }
    let (parent, stem) = (path.parent().unwrap_or(folder), path.file_stem().unwrap_or_default().to_string_lossy());
    let stems = stems(parent);
    let there = stems.iter().map(String::as_str);
    let label = match nearest(&stem, there.clone()) {
        Some(near) => format!("did you mean `{near}`?"),
        None => format!("no file {}", path.display()),
    };
    let (what, place) = (format!("there is no `{stem}` in {}", parent.display()), parent.display());
    let error = ConfigError::new(what).helped(format!("in {place} there is {}", enumerate(there)));
    Err(error.labelled(label).spotted(sources, used))
}

/// The stems of the TOML files in a folder, sorted.
pub fn stems(folder: &Path) -> Vec<String> {
    let files = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let tomls = files.filter(|path| path.extension().is_some_and(|extension| extension == "toml"));
    let mut stems: Vec<String> = tomls.filter_map(|path| Some(path.file_stem()?.to_str()?.to_owned())).collect();
    stems.sort_unstable();
    stems
}

/// A path as errors show it: `a/../b` folded to `b`, relative to the current folder where it lies in it.
pub(super) fn shown(path: &Path) -> PathBuf {
    let mut folded = PathBuf::new();
    for component in path.components() {
        match component {
            Component::CurDir => {}
            Component::ParentDir if matches!(folded.components().next_back(), Some(Component::Normal(_))) => {
                folded.pop();
            }
            other => folded.push(other),
        }
    }
    match std::env::current_dir().ok().and_then(|here| folded.strip_prefix(here).ok().map(Path::to_owned)) {
        Some(inside) if !inside.as_os_str().is_empty() => inside,
        _ => folded,
    }
}

/// A selection by name written out as tables: `"a"` is `{ extends = "a" }`, `["a", "b"]` is `{ a = …, b = … }`.
///
/// In this form a later layer can change single keys of a part that an earlier one selects.
pub(super) fn select(node: Node) -> Node {
    let from = |word: &str, place: Option<Place>| {
        let name = Node { value: Value::Text(word.to_owned()), place };
        Table::from([("extends".to_owned(), Entry { key: place, node: name })])
    };
    let value = match (&node.value, node.words()) {
        (Value::Text(word), _) => Value::Table(from(word, node.place)),
        (_, Some(words)) => {
            let part = |(word, place): (&str, Option<Place>)| {
                let stem = Path::new(word).file_stem().unwrap_or_default().to_string_lossy().into_owned();
                (stem, Entry { key: place, node: Node { value: Value::Table(from(word, place)), place } })
            };
            Value::Table(words.into_iter().map(part).collect())
        }
        _ => return node,
    };
    Node { value, place: node.place }
}
