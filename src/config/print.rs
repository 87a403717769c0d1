//! Tree → TOML.
use super::tree::{Node, Table, Value};

/// Writes a tree as TOML, with `note` behind every leaf.
pub(super) struct Printer<F> {
    text: String,
    note: F,
}

/// TOML of a table; `note` gives the comment of a leaf.
pub(super) fn print(root: &Node, note: impl Fn(&Node) -> Option<String>) -> String {
    let mut printer = Printer { text: String::new(), note };
    if let Some(table) = root.table() {
        printer.table(table, "");
    }
    printer.text
}

impl<F: Fn(&Node) -> Option<String>> Printer<F> {
    fn table(&mut self, table: &Table, path: &str) {
        for (key, entry) in table.iter().filter(|(_, entry)| !has_header(&entry.node)) {
            let (key, value) = (quoted_key(key), inline(&entry.node));
            let note = (self.note)(&entry.node).map_or_else(String::new, |note| format!("  # {note}"));
            self.text += &format!("{key} = {value}{note}\n");
        }
        for (key, entry) in table.iter().filter(|(_, entry)| has_header(&entry.node)) {
            let key = quoted_key(key);
            let path = if path.is_empty() { key } else { format!("{path}.{key}") };
            match &entry.node.value {
                Value::Table(inner) => {
                    if inner.is_empty() || inner.values().any(|entry| !has_header(&entry.node)) {
                        self.header(&format!("[{path}]"));
                    }
                    self.table(inner, &path);
                }
                Value::List(items) => {
                    for inner in items.iter().filter_map(Node::table) {
                        self.header(&format!("[[{path}]]"));
                        self.table(inner, &path);
                    }
                }
                _ => {}
            }
        }
    }

    fn header(&mut self, header: &str) {
        let gap = if self.text.is_empty() { "" } else { "\n" };
        self.text += &format!("{gap}{header}\n");
    }
}

/// Whether a value is written under a `[header]` of its own rather than behind `key =`.
fn has_header(node: &Node) -> bool {
    match &node.value {
        Value::Table(_) => true,
        Value::List(items) => !items.is_empty() && items.iter().all(|item| item.table().is_some()),
        _ => false,
    }
}

fn quoted_key(key: &str) -> String {
    let bare = |letter: char| letter.is_ascii_alphanumeric() || letter == '_' || letter == '-';
    if !key.is_empty() && key.chars().all(bare) { key.to_owned() } else { quoted(key) }
}

fn quoted(text: &str) -> String {
    toml_edit::Value::from(text).to_string().trim().to_owned()
}

/// A value on one line, however deep.
pub(super) fn inline(node: &Node) -> String {
    match &node.value {
        Value::Flag(flag) => flag.to_string(),
        Value::Integer(integer) => integer.to_string(),
        // the shortest text that reads back as the same bits, with an exponent where it is far from one
        Value::Number(number) => format!("{number:?}"),
        Value::Text(text) if text.contains('\n') => one_line(text),
        Value::Text(text) => quoted(text),
        Value::List(items) => format!("[{}]", items.iter().map(inline).collect::<Vec<_>>().join(", ")),
        Value::Table(table) => {
            let entries = table.iter().map(|(key, entry)| format!("{} = {}", quoted_key(key), inline(&entry.node)));
            format!("{{ {} }}", entries.collect::<Vec<_>>().join(", "))
        }
    }
}

fn one_line(text: &str) -> String {
    let lines: Vec<String> = text.split('\n').map(basic).collect();
    format!("\"{}\"", lines.join("\\n"))
}

fn basic(line: &str) -> String {
    let escape = |letter: char| match letter {
        '"' | '\\' => format!("\\{letter}"),
        '\t' => "\\t".to_owned(),
        control if control.is_control() => format!("\\u{:04X}", control as u32),
        plain => plain.to_string(),
    };
    line.chars().map(escape).collect()
}
