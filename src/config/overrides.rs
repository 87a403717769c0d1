//! `key=value`, `+key=value`, `++key=value` and `~key` on the command line (Hydra's grammar).
use super::error::ConfigError;
use super::group::{Groups, select};
use super::merge::merge;
use super::parse::DEEPEST;
use super::print::inline;
use super::source::{Manner, Place, Sources};
use super::suggest::{enumerate, nearest};
use super::tree::{Entry, Node, Table, Value};
use super::word::Reader;
use serde_json::Value as Json;

/// The override `key=value`, with the value as the command line takes it.
pub(crate) fn assignment(key: &str, value: &Json) -> String {
    let bare = |letter: char| letter.is_ascii_alphanumeric() || matches!(letter, '_' | '-' | '.' | '/');
    match value {
        Json::String(word) if word.starts_with(char::is_alphabetic) && word.chars().all(bare) && !spoken_for(word) => {
            format!("{key}={word}")
        }
        value => format!("{key}={}", Node::from_json(value, None).map_or_else(String::new, |node| inline(&node))),
    }
}

fn spoken_for(word: &str) -> bool {
    matches!(word, "true" | "false" | "inf" | "nan")
}

/// The key that an override is about and the value it gives to it, `null` for a deletion.
///
/// # Errors
/// It is no override.
pub(crate) fn meaning(text: &str) -> Result<(String, Json), ConfigError> {
    let Override { path, action } = Override::parse(text, &mut Sources::default())?;
    let key = path.into_iter().map(|(key, _)| key).collect::<Vec<_>>().join(".");
    Ok(match action {
        Action::Set(node) | Action::Add(node) => (key, node.to_json()),
        Action::Delete => (key, Json::Null),
    })
}

/// One command-line override.
#[derive(Debug)]
pub(super) struct Override {
    path: Vec<(String, Place)>,
    action: Action,
}

#[derive(Debug)]
enum Action {
    Set(Node),
    Add(Node),
    Delete,
}

impl Override {
    /// Reads one argument.
    ///
    /// # Errors
    /// It is not of that grammar; the caret stands where it ceases to be.
    pub(super) fn parse(text: &str, sources: &mut Sources) -> Result<Self, ConfigError> {
        let path_end = text.find('=').unwrap_or(text.len());
        let manner = if text.starts_with(['+', '~']) { Manner::Edit } else { Manner::Change { path_end } };
        let source = sources.add(format!("command line `{text}`"), text.to_owned(), manner);
        let mut reader = Reader { text, at: 0, source, sources };
        let (force, add, delete) = match (text.starts_with("++"), text.starts_with('+'), text.starts_with('~')) {
            (true, _, _) => (2, false, false),
            (_, add, delete) => (usize::from(add || delete), add, delete),
        };
        reader.at = force;
        let mut path = vec![reader.key(&['.', '='])?];
        while reader.take('.') {
            path.push(reader.key(&['.', '='])?);
            if path.len() > DEEPEST {
                return Err(reader.refuse(format!("a key is nested more than {DEEPEST} deep"), 0));
            }
        }
        let action = match (delete, reader.take('=')) {
            (true, false) => Action::Delete,
            (true, true) => return Err(reader.refuse("a deletion is `~key`, without a value", path_end)),
            (false, true) if add => Action::Add(reader.whole_value()?),
            (false, true) => Action::Set(reader.whole_value()?),
            (false, false) => return Err(reader.refuse("an override is `key=value`, `+key=value` or `~key`", 0)),
        };
        Ok(Self { path, action })
    }

    fn key(&self) -> &str {
        self.path.last().map_or("", |(key, _)| key)
    }

    /// Whether it names parts, so that it counts before parts are read.
    pub(super) fn selects(&self, groups: &Groups) -> bool {
        matches!(&self.action, Action::Set(node) | Action::Add(node) if groups.has(self.key()) && node.words().is_some())
    }

    /// How many keys its path has.
    pub(super) fn depth(&self) -> usize {
        self.path.len()
    }

    /// Changes the tree.
    ///
    /// # Errors
    /// A key to delete is not there, a key to add is, or the path leads through something that is no table.
    pub(super) fn apply(self, root: &mut Node, groups: &Groups, sources: &Sources) -> Result<(), ConfigError> {
        let Some(((key, place), above)) = self.path.split_last() else { return Ok(()) };
        let mut node = root;
        let mut parent = "";
        for (index, (step, at)) in above.iter().enumerate() {
            if groups.has(parent) {
                let whole = std::mem::replace(node, Node::empty(None));
                *node = select(whole);
            }
            let noun = node.noun();
            node = match &mut node.value {
                Value::List(items) => element(items, step, *at, sources)?,
                Value::Table(table) if matches!(self.action, Action::Delete) && !table.contains_key(step) => {
                    return Err(absent(table, step, *at, sources));
                }
                Value::Table(table) => {
                    let made = Entry { key: Some(*at), node: Node::empty(None) };
                    &mut table.entry(step.clone()).or_insert(made).node
                }
                _ => {
                    return Err(no_table(&above[..index], noun, step, *at, sources));
                }
            };
            parent = step;
        }
        if groups.has(parent) {
            let whole = std::mem::replace(node, Node::empty(None));
            *node = select(whole);
        }
        let noun = node.noun();
        match (&mut node.value, self.action) {
            (Value::Table(table), Action::Delete) => match table.shift_remove(key) {
                Some(_) => Ok(()),
                None => Err(absent(table, key, *place, sources)),
            },
            (Value::Table(table), Action::Add(_)) if table.contains_key(key) => {
                let error = ConfigError::new(format!("`{key}` is there already"));
                let advice = "leave out the `+` to change it, or write `++` to set it either way";
                Err(error.labelled("already there").helped(advice).spotted(sources, Some(*place)))
            }
            (Value::Table(table), Action::Set(value) | Action::Add(value)) => {
                match table.get_mut(key) {
                    Some(entry) => {
                        let old = std::mem::replace(&mut entry.node, Node::empty(None));
                        entry.node = merge(old, value, Some(key), groups);
                    }
                    None => drop(table.insert(key.clone(), Entry { key: Some(*place), node: value })),
                }
                Ok(())
            }
            (Value::List(items), Action::Set(value)) => {
                *element(items, key, *place, sources)? = value;
                Ok(())
            }
            (Value::List(_), _) => {
                let why =
                    "elements of a list can be changed (`list.0=value`), not added or deleted: write the whole list";
                Err(ConfigError::new(why).spotted(sources, Some(*place)))
            }
            _ => Err(no_table(above, noun, key, *place, sources)),
        }
    }
}

fn element<'a>(items: &'a mut [Node], step: &str, at: Place, sources: &Sources) -> Result<&'a mut Node, ConfigError> {
    let length = items.len();
    step.parse::<usize>().ok().and_then(|index| items.get_mut(index)).ok_or_else(|| {
        let why = format!("a list of {length} has no element `{step}`: elements count from 0");
        ConfigError::new(why).spotted(sources, Some(at))
    })
}

fn no_table(path: &[(String, Place)], noun: &str, key: &str, place: Place, sources: &Sources) -> ConfigError {
    let path: Vec<&str> = path.iter().map(|(key, _)| key.as_str()).collect();
    ConfigError::new(format!("`{}` is {noun}, so it has no key `{key}`", path.join("."))).spotted(sources, Some(place))
}

fn absent(table: &Table, key: &str, place: Place, sources: &Sources) -> ConfigError {
    let there = table.keys().map(String::as_str);
    let label = match nearest(key, there.clone()) {
        Some(near) => format!("did you mean `{near}`?"),
        None => "not there".to_owned(),
    };
    let error = ConfigError::new(format!("there is no `{key}` to delete")).labelled(label);
    error.helped(format!("there is {}", enumerate(there))).spotted(sources, Some(place))
}
