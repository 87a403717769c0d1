//! Constants of a model's config, named by their path: `laws.contact.stiffness` is `stiffness` of the list item of
//! `laws` whose `name`, or where it has none whose `kind`, is `contact`; what is not in a table itself is looked for in its
//! `constants`, so that laws written as formulas are addressed as all others are.
use anyhow::Context;
use serde_json::Value;

/// The constant at `path`.
///
/// # Errors
/// When there is none, naming the nearest that there is; when it is not a positive real number.
pub fn value(spec: &Value, path: &str) -> anyhow::Result<f64> {
    let Some(found) = path.split('.').try_fold(spec, |v, key| child(v, key)) else {
        let mut known = Vec::new();
        leaves(spec, "", &mut known);
        let nearest =
            known.iter().max_by(|a, b| strsim::jaro_winkler(a, path).total_cmp(&strsim::jaro_winkler(b, path)));
        match nearest {
            Some(nearest) => anyhow::bail!("the model has no constant `{path}`; did you mean `{nearest}`?"),
            None => anyhow::bail!("the model has no constant `{path}`, nor any other"),
        }
    };
    match found.as_f64() {
        Some(number) if found.is_f64() && number > 0.0 => Ok(number),
        _ => anyhow::bail!("`{path}` of the model is {found}; only positive real numbers can be identified"),
    }
}

/// A copy of `spec` with `constants` in place of those at their paths.
///
/// # Errors
/// As [`value`].
pub fn replace<'a>(spec: &Value, constants: impl IntoIterator<Item = (&'a str, f64)>) -> anyhow::Result<Value> {
    let mut spec = spec.clone();
    for (path, number) in constants {
        value(&spec, path)?;
        let found = path.split('.').try_fold(&mut spec, |v, key| child_mut(v, key));
        *found.expect("a path that was just read") = Value::from(number);
    }
    Ok(spec)
}

/// A copy of `spec` with `entry` at `path`, whose last key may be absent so far.
///
/// # Errors
/// When there is nothing that could have this key.
pub(super) fn put(spec: &Value, path: &str, entry: Value) -> anyhow::Result<Value> {
    let mut spec = spec.clone();
    let (parent, key) = path.rsplit_once('.').unwrap_or(("", path));
    let keys = parent.split('.').filter(|key| !key.is_empty());
    let found = keys.into_iter().try_fold(&mut spec, |v, key| child_mut(v, key)).and_then(Value::as_object_mut);
    let table = found.with_context(|| format!("the model has no `{parent}` that could have `{key}`"))?;
    table.insert(key.to_owned(), entry);
    Ok(spec)
}

/// A copy of `spec` without what stands at `path`.
///
/// # Errors
/// When nothing stands there.
pub(super) fn without(spec: &Value, path: &str) -> anyhow::Result<Value> {
    let mut spec = spec.clone();
    let (parent, key) = path.rsplit_once('.').unwrap_or(("", path));
    let keys = parent.split('.').filter(|key| !key.is_empty());
    let found = keys.into_iter().try_fold(&mut spec, |v, key| child_mut(v, key)).and_then(Value::as_object_mut);
    let removed = found.and_then(|table| table.shift_remove(key));
    removed
        .with_context(|| format!("`leave_out` of the identification names `{path}`, which the model does not have"))?;
    Ok(spec)
}

/// The table whose keys are addressed as if they stood around it.
const CONSTANTS: &str = "constants";

/// What a list item is addressed by.
fn called(item: &Value) -> Option<&str> {
    item["name"].as_str().or_else(|| item["kind"].as_str())
}

fn child<'a>(value: &'a Value, key: &str) -> Option<&'a Value> {
    match value {
        Value::Object(map) => map.get(key).or_else(|| map.get(CONSTANTS)?.get(key)),
        Value::Array(items) => items.iter().find(|item| called(item) == Some(key)),
        _ => None,
    }
}

fn child_mut<'a>(value: &'a mut Value, key: &str) -> Option<&'a mut Value> {
    match value {
        Value::Object(map) => {
            let own = map.contains_key(key);
            if own { map.get_mut(key) } else { map.get_mut(CONSTANTS)?.get_mut(key) }
        }
        Value::Array(items) => items.iter_mut().find(|item| called(item) == Some(key)),
        _ => None,
    }
}

/// Paths of all real numbers below `value`.
fn leaves(value: &Value, path: &str, out: &mut Vec<String>) {
    let below = |key: &str| if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
    match value {
        Value::Object(map) => map.iter().for_each(|(key, v)| {
            let around = key == CONSTANTS && v.is_object();
            leaves(v, &if around { path.to_owned() } else { below(key) }, out);
        }),
        Value::Array(items) => {
            for item in items {
                if let Some(name) = called(item) {
                    leaves(item, &below(name), out);
                }
            }
        }
        Value::Number(number) if number.is_f64() => out.push(path.to_owned()),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn spec() -> Value {
        json!({"kind": "particles", "substeps": 4, "laws": [
            {"kind": "contact", "stiffness": 2.0, "damping": 0.5},
            {"kind": "friction", "coefficient": 0.3},
        ]})
    }

    #[test]
    fn list_items_are_addressed_by_kind() {
        let changed = replace(&spec(), [("laws.friction.coefficient", 0.7)]).unwrap();
        assert_eq!(value(&changed, "laws.friction.coefficient").unwrap(), 0.7);
        assert_eq!(value(&changed, "laws.contact.stiffness").unwrap(), 2.0);
        let back = replace(&changed, [("laws.friction.coefficient", 0.3)]).unwrap();
        assert_eq!(back, spec());
    }

    #[test]
    fn constants_of_formulas_are_addressed_as_all_others_are() {
        let spec = json!({"laws": [
            {"kind": "formula", "name": "contact", "reach": 0.1, "constants": {"stiffness": 2.0}},
            {"kind": "formula", "name": "bond", "reach": 0.2, "constants": {"stiffness": 3.0}},
        ]});
        let changed = replace(&spec, [("laws.bond.stiffness", 5.0), ("laws.bond.reach", 0.3)]).unwrap();
        assert_eq!(value(&changed, "laws.bond.stiffness").unwrap(), 5.0);
        assert_eq!(value(&changed, "laws.contact.stiffness").unwrap(), 2.0);
        assert_eq!(
            changed["laws"][1],
            json!({"kind": "formula", "name": "bond", "reach": 0.3, "constants": {"stiffness": 5.0}})
        );
        let error = value(&spec, "laws.bond.stifness").unwrap_err().to_string();
        assert!(error.contains("`laws.bond.stiffness`"), "{error}");
        assert!(value(&spec, "laws.formula.stiffness").is_err());
    }

    #[test]
    fn a_key_that_is_absent_can_be_put_where_there_is_a_place_for_it() {
        let changed = put(&spec(), "laws.contact.weights", json!("w.safetensors")).unwrap();
        assert_eq!(changed["laws"][0]["weights"], "w.safetensors");
        assert_eq!(put(&spec(), "seed", json!(1)).unwrap()["seed"], 1);
        let alone = without(&changed, "laws.contact.weights").unwrap();
        assert_eq!(alone, spec());
        let error = without(&spec(), "corrections").unwrap_err().to_string();
        assert!(error.contains("`corrections`"), "{error}");
        let error = put(&spec(), "laws.learned.weights", json!(1)).unwrap_err().to_string();
        assert!(error.contains("`laws.learned`"), "{error}");
    }

    #[test]
    fn an_unknown_path_is_answered_with_the_nearest() {
        let error = value(&spec(), "laws.contact.stifness").unwrap_err().to_string();
        assert!(error.contains("`laws.contact.stiffness`"), "{error}");
        let whole = value(&spec(), "substeps").unwrap_err().to_string();
        assert!(whole.contains("positive real"), "{whole}");
    }
}
