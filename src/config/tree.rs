//! A config as a tree in which every value knows where it was written.
use super::source::Place;
use indexmap::IndexMap;
use serde_json::Value as Json;

/// A key's value and the place of the key itself.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    pub(super) key: Option<Place>,
    pub(super) node: Node,
}

/// Keys in the order they were written.
pub(super) type Table = IndexMap<String, Entry>;

/// What TOML can say, less its dates.
#[derive(Clone, Debug)]
pub(super) enum Value {
    Flag(bool),
    Integer(i64),
    Number(f64),
    Text(String),
    List(Vec<Node>),
    Table(Table),
}

/// A value and where it was written; a place of `None` is a default.
#[derive(Clone, Debug)]
pub(super) struct Node {
    pub(super) value: Value,
    pub(super) place: Option<Place>,
}

impl Node {
    /// A table without keys.
    pub(super) fn empty(place: Option<Place>) -> Self {
        Self { value: Value::Table(Table::new()), place }
    }

    /// Its entries, when it is a table.
    pub(super) fn table(&self) -> Option<&Table> {
        match &self.value {
            Value::Table(table) => Some(table),
            _ => None,
        }
    }

    /// Its words with their places, when it is a string or a list of nothing but strings.
    pub(super) fn words(&self) -> Option<Vec<(&str, Option<Place>)>> {
        match &self.value {
            Value::Text(word) => Some(vec![(word, self.place)]),
            Value::List(items) => items
                .iter()
                .map(|item| match &item.value {
                    Value::Text(word) => Some((word.as_str(), item.place)),
                    _ => None,
                })
                .collect(),
            _ => None,
        }
    }

    /// What kind of value this is, with its article.
    pub(super) fn noun(&self) -> &'static str {
        match self.value {
            Value::Flag(_) => "a boolean",
            Value::Integer(_) => "an integer",
            Value::Number(_) => "a number with a point",
            Value::Text(_) => "a string",
            Value::List(_) => "a list",
            Value::Table(_) => "a table",
        }
    }

    /// The same value without its places.
    pub(super) fn to_json(&self) -> Json {
        match &self.value {
            Value::Flag(flag) => Json::from(*flag),
            Value::Integer(integer) => Json::from(*integer),
            Value::Number(number) => Json::from(*number),
            Value::Text(text) => Json::from(text.as_str()),
            Value::List(items) => items.iter().map(Node::to_json).collect(),
            Value::Table(table) => table.iter().map(|(key, entry)| (key.clone(), entry.node.to_json())).collect(),
        }
    }

    /// A tree of `json`, whose values take the places that the same keys have in `written`.
    ///
    /// TOML has no null, so a null is a key left out.
    pub(super) fn from_json(json: &Json, written: Option<&Node>) -> Option<Self> {
        let value = match json {
            Json::Null => return None,
            Json::Bool(flag) => Value::Flag(*flag),
            Json::Number(number) => match number.as_i64() {
                Some(integer) => Value::Integer(integer),
                None => Value::Number(number.as_f64()?),
            },
            Json::String(text) => Value::Text(text.clone()),
            Json::Array(items) => {
                let old = |index: usize| match written.map(|node| &node.value) {
                    Some(Value::List(old)) => old.get(index),
                    _ => None,
                };
                let items = items.iter().enumerate();
                Value::List(items.filter_map(|(index, item)| Self::from_json(item, old(index))).collect())
            }
            Json::Object(members) => {
                let old = written.and_then(Node::table);
                let entry = |(key, member): (&String, &Json)| {
                    let old = old.and_then(|table| table.get(key));
                    let node = Self::from_json(member, old.map(|entry| &entry.node))?;
                    Some((key.clone(), Entry { key: old.and_then(|entry| entry.key), node }))
                };
                Value::Table(members.iter().filter_map(entry).collect())
            }
        };
        Some(Self { value, place: written.and_then(|node| node.place) })
    }
}
