//! A config with every value filled in, each knowing where it came from.
use super::print::print;
use super::source::{Manner, Place, Sources};
use super::tree::{Node, Value};
use serde::Serialize;
use std::sync::Arc;

/// The whole config that a run used: what files and overrides say, and the defaults of the rest.
#[derive(Clone, Debug)]
pub struct Resolved {
    root: Node,
    sources: Arc<Sources>,
}

impl Resolved {
    /// A config made in code: every value counts as a default.
    pub fn of(spec: &impl Serialize) -> Self {
        Self::filled(spec, &Node::empty(None), Sources::default())
    }

    /// All values of `spec`, with the places that `written` has for them.
    pub(super) fn filled(spec: &impl Serialize, written: &Node, sources: Sources) -> Self {
        let json = serde_json::to_value(spec).expect("specs have string keys and derived serialisation");
        let root = Node::from_json(&json, Some(written)).unwrap_or_else(|| Node::empty(None));
        Self { root, sources: Arc::new(sources) }
    }

    /// The config as TOML without `extends` or names of parts; loading it gives the same config again.
    pub fn to_toml(&self) -> String {
        print(&self.root, |_| None)
    }

    /// The same TOML with the origin of each value as a comment: file and line, command line, or default.
    pub fn annotated(&self) -> String {
        print(&self.root, |leaf| Some(self.origin(leaf)))
    }

    fn origin(&self, leaf: &Node) -> String {
        let Some(place) = leaf.place else { return "default".to_owned() };
        match self.sources.of(place).manner {
            Manner::File => format!("from {}", self.sources.describe(place)),
            Manner::Change { .. } | Manner::Edit => "from command line".to_owned(),
        }
    }

    /// Where the value of `key` was written and `true`, or where the innermost written table around it was and `false`.
    pub(super) fn find(&self, key: &str) -> (Option<Place>, bool) {
        let mut node = &self.root;
        let mut place = node.place;
        for step in key.split('.') {
            let inner = match &node.value {
                Value::Table(table) => table.get(step).map(|entry| (&entry.node, entry.node.place.or(entry.key))),
                Value::List(items) => {
                    step.parse::<usize>().ok().and_then(|index| items.get(index)).map(|item| (item, item.place))
                }
                _ => None,
            };
            match inner {
                Some((inner, Some(written))) => (node, place) = (inner, Some(written)),
                _ => return (place, false),
            }
        }
        (place, true)
    }

    pub(super) fn sources(&self) -> &Sources {
        &self.sources
    }
}
