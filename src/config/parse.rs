//! TOML text → tree.
use super::error::ConfigError;
use super::source::{Manner, Place, Sources};
use super::tree::{Entry, Node, Table, Value};
use std::fs::File;
use std::io::Read;
use std::path::Path;
use toml_edit::{Item, TableLike};

/// Configs of more bytes than this are data, not configs.
const LARGEST: u64 = 4 << 20;
/// Tables and lists may stand inside each other so many times.
pub(super) const DEEPEST: usize = 64;

/// Reads one file into a tree; its `extends` and named parts still stand in it as written.
///
/// # Errors
/// The file cannot be read, is not UTF-8, not TOML, too large or too deep; `used` is where its name was written.
pub(super) fn parse_file(path: &Path, used: Option<Place>, sources: &mut Sources) -> Result<Node, ConfigError> {
    let name = path.display().to_string();
    let refuse = |why: String, sources: &Sources| ConfigError::new(why).spotted(sources, used);
    let mut bytes = Vec::new();
    let read = File::open(path).and_then(|file| file.take(LARGEST + 1).read_to_end(&mut bytes));
    if let Err(error) = read {
        let why = if path.is_dir() { "it is a folder, not a TOML file".to_owned() } else { error.to_string() };
        return Err(refuse(format!("cannot read `{name}`: {why}"), sources));
    }
    if bytes.len() as u64 > LARGEST {
        return Err(refuse(format!("`{name}` is larger than {} MiB: that is no config", LARGEST >> 20), sources));
    }
    let text = String::from_utf8(bytes).map_err(|error| {
        let good = error.utf8_error().valid_up_to();
        let line = error.as_bytes()[..good].iter().filter(|byte| **byte == b'\n').count() + 1;
        refuse(format!("`{name}` is not UTF-8 text: byte {good}, in line {line}, is to blame"), sources)
    })?;
    let source = sources.add(name, text.clone(), Manner::File);
    let document = toml_edit::Document::parse(text).map_err(|error| {
        let place = error.span().map(|span| Place::new(source, span));
        ConfigError::new(format!("not TOML: {}", error.message().trim().replace('\n', "; "))).spotted(sources, place)
    })?;
    let walk = Walk { source, sources };
    let top = Place::new(source, 0..0);
    Ok(Node { value: Value::Table(walk.table(document.as_table(), top, 0)?), place: Some(top) })
}

struct Walk<'a> {
    source: usize,
    sources: &'a Sources,
}

impl Walk<'_> {
    fn place(&self, span: Option<std::ops::Range<usize>>, around: Place) -> Place {
        span.map_or(around, |span| Place::new(self.source, span))
    }

    fn refuse(&self, why: &str, place: Place) -> ConfigError {
        ConfigError::new(why).spotted(self.sources, Some(place))
    }

    fn table(&self, table: &dyn TableLike, around: Place, depth: usize) -> Result<Table, ConfigError> {
        let mut entries = Table::with_capacity(table.len());
        for (key, item) in table.iter() {
            let place = self.place(table.key(key).and_then(toml_edit::Key::span), around);
            let node = self.item(item, place, depth + 1)?;
            entries.insert(key.to_owned(), Entry { key: Some(place), node });
        }
        Ok(entries)
    }

    fn item(&self, item: &Item, around: Place, depth: usize) -> Result<Node, ConfigError> {
        let place = self.place(item.span(), around);
        if depth > DEEPEST {
            return Err(self.refuse(&format!("tables and lists are nested more than {DEEPEST} deep"), place));
        }
        let value = match item {
            Item::None => Value::Table(Table::new()),
            Item::Table(table) => Value::Table(self.table(table, place, depth)?),
            Item::ArrayOfTables(tables) => {
                let node = |table: &toml_edit::Table| {
                    let place = self.place(table.span(), place);
                    Ok(Node { value: Value::Table(self.table(table, place, depth + 1)?), place: Some(place) })
                };
                Value::List(tables.iter().map(node).collect::<Result<_, _>>()?)
            }
            Item::Value(value) => self.value(value, place, depth)?,
        };
        Ok(Node { value, place: Some(place) })
    }

    fn value(&self, value: &toml_edit::Value, place: Place, depth: usize) -> Result<Value, ConfigError> {
        Ok(match value {
            toml_edit::Value::Boolean(flag) => Value::Flag(*flag.value()),
            toml_edit::Value::Integer(integer) => Value::Integer(*integer.value()),
            toml_edit::Value::Float(number) if number.value().is_finite() => Value::Number(*number.value()),
            toml_edit::Value::Float(_) => return Err(self.refuse("a number here must be finite", place)),
            toml_edit::Value::String(text) => Value::Text(text.value().clone()),
            toml_edit::Value::Datetime(_) => {
                return Err(self.refuse("no key takes a date; a string needs quotes around it", place));
            }
            toml_edit::Value::InlineTable(table) => Value::Table(self.table(table, place, depth)?),
            toml_edit::Value::Array(items) => {
                let node = |item: &toml_edit::Value| {
                    let place = self.place(item.span(), place);
                    if depth >= DEEPEST {
                        return Err(self.refuse(&format!("lists are nested more than {DEEPEST} deep"), place));
                    }
                    Ok(Node { value: self.value(item, place, depth + 1)?, place: Some(place) })
                };
                Value::List(items.iter().map(node).collect::<Result<_, _>>()?)
            }
        })
    }
}
