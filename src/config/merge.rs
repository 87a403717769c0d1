//! One layer of a config over another.
use super::group::{Groups, select};
use super::tree::{Entry, Node, Value};

/// `over` on top of `under`, the value of `key`: tables merge key by key, everything else replaces.
///
/// A table with `extends` starts from another part, so it replaces too; a table over the name of a part changes keys
/// of that part.
pub(super) fn merge(under: Node, over: Node, key: Option<&str>, groups: &Groups) -> Node {
    let under = match &over.value {
        Value::Table(table) if table.contains_key("extends") => return over,
        Value::Table(_) if key.is_some_and(|key| groups.has(key)) => select(under),
        _ => under,
    };
    match (under.value, over.value) {
        (Value::Table(mut entries), Value::Table(newer)) => {
            for (key, entry) in newer {
                let merged = match entries.get_mut(&key) {
                    Some(old) => {
                        let under = std::mem::replace(&mut old.node, Node::empty(None));
                        Entry { node: merge(under, entry.node, Some(&key), groups), key: old.key.or(entry.key) }
                    }
                    None => entry,
                };
                entries.insert(key, merged);
            }
            Node { value: Value::Table(entries), place: over.place.or(under.place) }
        }
        (_, value) => Node { value, place: over.place },
    }
}
