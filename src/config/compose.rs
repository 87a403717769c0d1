//! Files → one tree: `extends` and named parts.
use super::error::ConfigError;
use super::group::{Groups, locate, select};
use super::merge::merge;
use super::parse::{DEEPEST, parse_file};
use super::shape::{Property, Shape};
use super::source::{Place, Sources};
use super::tree::{Entry, Node, Table, Value};
use std::path::{Path, PathBuf};

/// A config is made of so many files at most; more come only from parts that name parts without end.
const MOST_FILES: usize = 4096;

/// Reads files and remembers which are being read, so that a circle is seen.
pub(super) struct Composer {
    pub(super) sources: Sources,
    pub(super) groups: Groups,
    open: Vec<(PathBuf, PathBuf)>,
}

impl Composer {
    pub(super) fn new(groups: Groups) -> Self {
        Self { sources: Sources::default(), groups, open: Vec::new() }
    }

    /// A file on top of all that it extends; named parts still stand in it by name.
    ///
    /// # Errors
    /// A file is missing, unreadable, or extends itself.
    pub(super) fn layered(&mut self, path: &Path, used: Option<Place>) -> Result<Node, ConfigError> {
        self.enter(path, used)?;
        let mut node = parse_file(path, used, &mut self.sources)?;
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        if let Some(under) = self.extended(&mut node, &folder)? {
            node = merge(under, node, None, &self.groups);
        }
        self.open.pop();
        Ok(node)
    }

    /// Takes `extends` out of a table and returns what it names, later names over earlier ones.
    fn extended(&mut self, node: &mut Node, folder: &Path) -> Result<Option<Node>, ConfigError> {
        let Value::Table(table) = &mut node.value else { return Ok(None) };
        let Some(entry) = table.shift_remove("extends") else { return Ok(None) };
        let Some(names) = entry.node.words() else {
            let error = ConfigError::new("`extends` takes the stem of a TOML file or a list of stems");
            return Err(error.labelled(entry.node.noun()).spotted(&self.sources, entry.node.place));
        };
        let mut under: Option<Node> = None;
        for (name, used) in names {
            let file = locate(folder, name, used, &self.sources)?;
            let layer = self.layered(&file, used)?;
            under = Some(match under {
                Some(under) => merge(under, layer, None, &self.groups),
                None => layer,
            });
        }
        Ok(under)
    }

    /// Replaces every name of a part by the part, at any depth, and what parts name in turn.
    ///
    /// `shape` tells where a string is meant as a string although its key is called like a folder.
    ///
    /// # Errors
    /// A part is missing, unreadable, or contains itself.
    pub(super) fn resolve(&mut self, node: Node, key: &str, shape: Option<&Shape>) -> Result<Node, ConfigError> {
        let group = self.groups.has(key).then(|| self.groups.folder(key));
        let Some(folder) = group else { return self.inside(node, shape) };
        if node.words().is_some() && shape.is_some_and(|shape| shape.takes_words(&node)) {
            return Ok(node);
        }
        let node = if node.words().is_some() { select(node) } else { node };
        let node = if shape.is_some_and(Shape::is_map) { entries_by_name(node) } else { node };
        match &node.value {
            Value::Table(table) if !table.contains_key("extends") => {
                let Node { value: Value::Table(table), place } = node else { return Ok(node) };
                let mut parts = Table::with_capacity(table.len());
                let outer = shape.and_then(|shape| shape.fit(&Node { value: Value::Table(table.clone()), place }).ok());
                for (name, entry) in table {
                    let below = outer.as_ref().and_then(|shape| child(shape, &name));
                    let is_part = !self.groups.has(&name)
                        && entry.node.table().is_some_and(|table| table.contains_key("extends"));
                    let node = match is_part {
                        true => self.part(entry.node, &folder, below.as_ref())?,
                        false => self.resolve(entry.node, &name, below.as_ref())?,
                    };
                    parts.insert(name, Entry { node, ..entry });
                }
                Ok(Node { value: Value::Table(parts), place })
            }
            _ => self.part(node, &folder, shape),
        }
    }

    /// A table on top of the parts in `folder` that its `extends` names, resolved.
    fn part(&mut self, mut node: Node, folder: &Path, shape: Option<&Shape>) -> Result<Node, ConfigError> {
        let names = node.table().and_then(|table| table.get("extends")).map(|entry| entry.node.clone());
        let Some(under) = self.extended(&mut node, folder)? else { return self.inside(node, shape) };
        let place = under.place;
        let whole = Node { place, ..merge(under, node, None, &self.groups) };
        let opened = self.open.len();
        for (name, used) in names.iter().filter_map(Node::words).flatten() {
            let file = locate(folder, name, used, &self.sources)?;
            self.enter(&file, used)?;
        }
        let whole = self.inside(whole, shape);
        self.open.truncate(opened);
        whole
    }

    fn inside(&mut self, node: Node, shape: Option<&Shape>) -> Result<Node, ConfigError> {
        let fitted = shape.and_then(|shape| shape.fit(&node).ok());
        let Node { value, place } = node;
        let value = match value {
            Value::Table(table) => {
                let mut resolved = Table::with_capacity(table.len());
                for (key, entry) in table {
                    let below = fitted.as_ref().and_then(|shape| child(shape, &key));
                    let node = self.resolve(entry.node, &key, below.as_ref())?;
                    resolved.insert(key, Entry { node, ..entry });
                }
                Value::Table(resolved)
            }
            Value::List(items) => {
                let below = |index: usize| fitted.as_ref().and_then(|shape| shape.item(index));
                let items = items.into_iter().enumerate();
                Value::List(
                    items.map(|(index, item)| self.inside(item, below(index).as_ref())).collect::<Result<_, _>>()?,
                )
            }
            leaf => leaf,
        };
        Ok(Node { value, place })
    }

    fn enter(&mut self, path: &Path, used: Option<Place>) -> Result<(), ConfigError> {
        let identity = std::fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        let shown = |(_, path): &(PathBuf, PathBuf)| path.display().to_string();
        if let Some(first) = self.open.iter().position(|(open, _)| *open == identity) {
            let chain: Vec<String> =
                self.open[first..].iter().chain([&(identity, path.to_owned())]).map(shown).collect();
            let error = ConfigError::new(format!("configs extend each other in a circle: {}", chain.join(" → ")));
            return Err(error.labelled("closes the circle").spotted(&self.sources, used));
        }
        if self.open.len() >= DEEPEST || self.sources.len() >= MOST_FILES {
            let most = format!("{DEEPEST} files inside each other or {MOST_FILES} in all");
            return Err(ConfigError::new(format!("this config has more than {most}")).spotted(&self.sources, used));
        }
        self.open.push((identity, path.to_owned()));
        Ok(())
    }
}

fn child<'a>(shape: &Shape<'a>, key: &str) -> Option<Shape<'a>> {
    match shape.property(key) {
        Property::Declared(shape) | Property::Free(shape) | Property::Open(shape) => Some(shape),
        Property::Unknown => None,
    }
}

/// Where entries are named freely, one selected part is an entry of its own name: `model = "a"` is `model = ["a"]`.
fn entries_by_name(mut node: Node) -> Node {
    let Value::Table(table) = &mut node.value else { return node };
    let Some(names) = table.shift_remove("extends").map(|entry| entry.node) else { return node };
    let Some(words) = names.words() else { return node };
    let items =
        words.iter().map(|(word, place)| Node { value: Value::Text((*word).to_owned()), place: *place }).collect();
    let Node { value: Value::Table(named), .. } = select(Node { value: Value::List(items), place: names.place }) else {
        return node;
    };
    for (name, part) in named {
        match table.get_mut(&name).map(|entry| &mut entry.node.value) {
            Some(Value::Table(own)) => {
                own.extend(part.node.table().into_iter().flatten().map(|(key, entry)| (key.clone(), entry.clone())));
            }
            Some(_) => {}
            None => drop(table.insert(name, part)),
        }
    }
    node
}
