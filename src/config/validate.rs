//! A tree against the JSON schema of the spec it is meant for.
use super::error::ConfigError;
use super::shape::{Misfit, Property, Shape, is_of_type};
use super::source::{Place, Sources};
use super::suggest::{enumerate, nearest};
use super::tree::{Node, Value};
use serde_json::Value as Json;

/// So many problems are told at once; whoever has more begins with these.
const TOLD: usize = 12;

/// Everything that is wrong with `root`, as one error.
///
/// # Errors
/// Unknown and missing keys, wrong types, values out of range, unknown kinds and words.
pub(super) fn validate(root: &Node, shape: &Shape, sources: &Sources) -> Result<(), ConfigError> {
    let mut check = Check { sources, problems: Vec::new() };
    check.node(root, shape, "");
    ConfigError::all(check.problems)
}

struct Check<'a> {
    sources: &'a Sources,
    problems: Vec<ConfigError>,
}

impl Check<'_> {
    fn report(&mut self, message: String, label: String, help: Option<String>, place: Option<Place>) {
        if self.problems.len() >= TOLD {
            return;
        }
        let error = ConfigError::new(message).labelled(label).spotted(self.sources, place);
        self.problems.push(match help {
            Some(help) => error.helped(help),
            None => error,
        });
    }

    fn node(&mut self, node: &Node, shape: &Shape, path: &str) {
        let shape = match shape.fit(node) {
            Ok(shape) => shape,
            Err(misfit) => return self.misfit(node, misfit, path),
        };
        let types = shape.types();
        if !types.is_empty() && !types.iter().any(|name| is_of_type(node, name)) {
            return self.wrong_type(node, &types, path);
        }
        match &node.value {
            Value::Text(word) => self.word(word, &shape, node.place, path),
            Value::Integer(integer) => self.range(*integer as f64, &shape, node.place, path),
            Value::Number(number) => self.range(*number, &shape, node.place, path),
            Value::List(items) => self.list(items, &shape, node.place, path),
            Value::Table(_) => self.table(node, &shape, path),
            Value::Flag(_) => {}
        }
    }

    fn misfit(&mut self, node: &Node, misfit: Misfit, path: &str) {
        match misfit {
            Misfit::Type(types) => self.wrong_type(node, &types, path),
            Misfit::Untagged { tag, kinds } => {
                let message = format!("missing key `{tag}` in {}", name(path));
                self.report(
                    message,
                    format!("needs `{tag}`"),
                    Some(format!("`{tag}` is {}", choice(&kinds))),
                    node.place,
                );
            }
            Misfit::Mistagged { tag, kinds, kind, place } => {
                let label = guess(&kind, kinds.iter().copied(), || format!("no such {tag}"));
                let help = Some(format!("`{tag}` is {}", choice(&kinds)));
                self.report(format!("unknown {tag} `{kind}` of {}", name(path)), label, help, place);
            }
        }
    }

    fn wrong_type(&mut self, node: &Node, types: &[&str], path: &str) {
        let mut nouns: Vec<&str> = types.iter().map(|name| noun(name)).collect();
        nouns.dedup();
        let help = match node.value {
            Value::Number(number) if types.contains(&"integer") && number.fract() == 0.0 && number.abs() < 1e15 => {
                Some(format!("write {number:.0}"))
            }
            Value::List(_) if types == ["object"] => Some("only strings in a list can name parts".to_owned()),
            _ => None,
        };
        let message = format!("{} must be {}, not {}", name(path), nouns.join(" or "), node.noun());
        self.report(message, node.noun().to_owned(), help, node.place);
    }

    fn word(&mut self, word: &str, shape: &Shape, place: Option<Place>, path: &str) {
        let words = shape.words();
        if !words.is_empty() && !words.contains(&word) {
            let label = guess(word, words.iter().copied(), || "not one of them".to_owned());
            self.report(format!("{} must be {}, not `{word}`", name(path), choice(&words)), label, None, place);
        }
        let length = word.chars().count() as f64;
        if shape.all("minLength").filter_map(Json::as_f64).any(|least| length < least) {
            self.report(format!("{} must not be so short", name(path)), "too short".to_owned(), None, place);
        }
    }

    fn range(&mut self, value: f64, shape: &Shape, place: Option<Place>, path: &str) {
        let bound = |keyword| shape.all(keyword).filter_map(Json::as_f64);
        let broken = bound("minimum").filter(|least| value < *least).map(|least| format!("at least {least}"));
        let broken = broken.chain(bound("maximum").filter(|most| value > *most).map(|most| format!("at most {most}")));
        let above = bound("exclusiveMinimum").filter(|low| value <= *low).map(|low| format!("greater than {low}"));
        let below = bound("exclusiveMaximum").filter(|high| value >= *high).map(|high| format!("less than {high}"));
        if let Some(rule) = broken.chain(above).chain(below).next() {
            self.report(format!("{} must be {rule}, not {value}", name(path)), format!("must be {rule}"), None, place);
        }
    }

    fn list(&mut self, items: &[Node], shape: &Shape, place: Option<Place>, path: &str) {
        let bound = |keyword| shape.all(keyword).filter_map(Json::as_u64).next();
        let (least, most, length) = (bound("minItems"), bound("maxItems"), items.len() as u64);
        if least.is_some_and(|least| length < least) || most.is_some_and(|most| length > most) {
            let wanted = match (least, most) {
                (Some(least), Some(most)) if least == most => format!("{least}"),
                (Some(least), Some(most)) => format!("{least} to {most}"),
                (Some(least), None) => format!("{least} or more"),
                (None, most) => format!("at most {}", most.unwrap_or(0)),
            };
            let message = format!("{} must have {wanted} elements, not {length}", name(path));
            self.report(message, format!("{length} elements"), None, place);
        }
        for (index, item) in items.iter().enumerate() {
            if let Some(shape) = shape.item(index) {
                self.node(item, &shape, &join(path, &index.to_string()));
            }
        }
    }

    fn table(&mut self, node: &Node, shape: &Shape, path: &str) {
        let Some(table) = node.table() else { return };
        for (key, entry) in table {
            let inner = join(path, key);
            // a table that only an override's path implies has no place but that path
            let below =
                |entry: &super::tree::Entry| Node { place: entry.node.place.or(entry.key), ..entry.node.clone() };
            match shape.property(key) {
                Property::Declared(shape) => self.node(&below(entry), &shape, &inner),
                Property::Free(shape) => match entry.key.is_some_and(|place| self.sources.presumed(place)) {
                    true => self.presumed(key, entry.key, node, path),
                    false => self.node(&below(entry), &shape, &inner),
                },
                Property::Unknown => {
                    let known: Vec<&str> = shape.declared().map(|(key, _)| key.as_str()).collect();
                    let label = guess(key, known.iter().copied(), || "no such key".to_owned());
                    let help = format!("the keys of {} are {}", name(path), enumerate(known));
                    self.report(format!("unknown key `{key}` in {}", name(path)), label, Some(help), entry.key);
                }
                Property::Open(_) => {}
            }
        }
        for key in shape.all("required").filter_map(Json::as_array).flatten().filter_map(Json::as_str) {
            if !table.contains_key(key) {
                let schema = shape.declared().find(|(known, _)| *known == key).map(|(_, schema)| schema);
                let meaning = schema.and_then(|schema| schema.get("description")).and_then(Json::as_str);
                // Units stand in brackets that documentation must escape.
                let meaning = meaning.map(|text| text.replace("\\[", "[").replace("\\]", "]"));
                let message = format!("missing key `{key}` in {}", name(path));
                let help = meaning.map(|meaning| format!("`{key}`: {meaning}"));
                self.report(message, format!("needs `{key}`"), help, node.place);
            }
        }
    }

    fn presumed(&mut self, key: &str, place: Option<Place>, node: &Node, path: &str) {
        let presumed = |place: &Option<Place>| place.is_some_and(|place| self.sources.presumed(place));
        let there = node.table().into_iter().flatten().filter(|(_, entry)| !presumed(&entry.key));
        let there: Vec<&str> = there.map(|(key, _)| key.as_str()).collect();
        let label = guess(key, there.iter().copied(), || "not there".to_owned());
        let help = format!("there is {}; to add one, write `+` before the override", enumerate(there));
        self.report(format!("there is no `{key}` in {}", name(path)), label, Some(help), place);
    }
}

fn guess<'a>(word: &str, known: impl IntoIterator<Item = &'a str>, otherwise: impl FnOnce() -> String) -> String {
    nearest(word, known).map_or_else(otherwise, |near| format!("did you mean `{near}`?"))
}

fn choice(words: &[&str]) -> String {
    match words {
        [] => "nothing".to_owned(),
        [only] => format!("`{only}`"),
        several => format!("one of {}", enumerate(several.iter().copied())),
    }
}

fn name(path: &str) -> String {
    if path.is_empty() { "the config".to_owned() } else { format!("`{path}`") }
}

fn join(path: &str, key: &str) -> String {
    if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") }
}

fn noun(schema_type: &str) -> &str {
    match schema_type {
        "boolean" => "true or false",
        "integer" => "an integer",
        "number" => "a number",
        "string" => "a string",
        "array" => "a list",
        "object" => "a table",
        other => other,
    }
}
