//! What a JSON schema says about one place of a config.
use super::source::Place;
use super::tree::{Node, Table, Value};
use serde_json::{Map, Value as Json};

/// All schema objects that hold for one value at once.
#[derive(Clone, Debug)]
pub(super) struct Shape<'a> {
    root: &'a Json,
    layers: Vec<&'a Map<String, Json>>,
}

/// What a table's schema says about one of its keys.
pub(super) enum Property<'a> {
    /// Declared by name.
    Declared(Shape<'a>),
    /// One of freely named entries.
    Free(Shape<'a>),
    /// Not allowed.
    Unknown,
    /// Anything may stand there.
    Open(Shape<'a>),
}

/// Why no alternative of a schema fits a value.
pub(super) enum Misfit<'a> {
    /// The key that tells the alternatives apart is missing.
    Untagged { tag: &'a str, kinds: Vec<&'a str> },
    /// It has a value that no alternative has.
    Mistagged { tag: &'a str, kinds: Vec<&'a str>, kind: String, place: Option<Place> },
    /// The value is not even of a type that any alternative takes.
    Type(Vec<&'a str>),
}

impl<'a> Shape<'a> {
    /// The shape of a whole config.
    pub(super) fn top(root: &'a Json) -> Self {
        Self::of(root, root)
    }

    fn of(root: &'a Json, schema: &'a Json) -> Self {
        let mut shape = Self { root, layers: Vec::new() };
        shape.include(schema);
        shape
    }

    fn include(&mut self, schema: &'a Json) {
        let Some(object) = schema.as_object() else { return };
        if self.layers.iter().any(|layer| std::ptr::eq(*layer, object)) {
            return;
        }
        self.layers.push(object);
        if let Some(target) = object.get("$ref").and_then(Json::as_str).and_then(|to| to.strip_prefix('#'))
            && let Some(target) = self.root.pointer(target)
        {
            self.include(target);
        }
        object.get("allOf").and_then(Json::as_array).into_iter().flatten().for_each(|part| self.include(part));
    }

    /// The values of a schema keyword, innermost last.
    pub(super) fn all(&self, keyword: &'static str) -> impl Iterator<Item = &'a Json> + '_ {
        self.layers.iter().filter_map(move |layer| layer.get(keyword))
    }

    /// The types that a value may have; none means any.
    pub(super) fn types(&self) -> Vec<&'a str> {
        let lists = self.all("type").map(|types| match types {
            Json::Array(types) => types.iter().filter_map(Json::as_str).collect(),
            one => one.as_str().into_iter().collect::<Vec<_>>(),
        });
        lists.flatten().filter(|name| *name != "null").collect()
    }

    /// The ways to fill this place, `null` aside; none when there is only this one.
    fn alternatives(&self) -> Option<Vec<Shape<'a>>> {
        let choices = self.all("oneOf").chain(self.all("anyOf")).next()?.as_array()?;
        let null = |choice: &&Json| choice.get("type").and_then(Json::as_str) != Some("null");
        Some(choices.iter().filter(null).map(|choice| Self::of(self.root, choice)).collect())
    }

    fn with(&self, chosen: &Shape<'a>) -> Shape<'a> {
        let decided = |layer: &&&'a Map<String, Json>| !layer.contains_key("oneOf") && !layer.contains_key("anyOf");
        let layers = self.layers.iter().filter(decided).chain(&chosen.layers).copied().collect();
        Shape { root: self.root, layers }
    }

    /// This shape with the alternative that fits `node`.
    ///
    /// # Errors
    /// None fits.
    pub(super) fn fit(&self, node: &Node) -> Result<Shape<'a>, Misfit<'a>> {
        let Some(alternatives) = self.alternatives() else { return Ok(self.clone()) };
        if let [only] = &alternatives[..] {
            return self.with(only).fit(node);
        }
        if let Some((tag, kinds)) = tags(&alternatives)
            && let Some(table) = node.table()
        {
            let Some(entry) = table.get(tag) else { return Err(Misfit::Untagged { tag, kinds }) };
            let Value::Text(kind) = &entry.node.value else { return Err(Misfit::Untagged { tag, kinds }) };
            return match kinds.iter().position(|known| known == kind) {
                Some(index) => self.with(&alternatives[index]).fit(node),
                None => Err(Misfit::Mistagged { tag, kinds, kind: kind.clone(), place: entry.node.place }),
            };
        }
        let suited = |shape: &&Shape<'a>| shape.suits(node) && shape.names(node.table());
        match alternatives.iter().find(suited).or_else(|| alternatives.iter().find(|shape| shape.suits(node))) {
            Some(shape) if !shape.words().is_empty() => Ok(self.clone()),
            Some(shape) => self.with(shape).fit(node),
            None => Err(Misfit::Type(alternatives.iter().flat_map(Shape::reachable_types).collect())),
        }
    }

    fn reachable_types(&self) -> Vec<&'a str> {
        let below = self.alternatives().into_iter().flatten().flat_map(|shape| shape.reachable_types());
        self.types().into_iter().chain(below).collect()
    }

    /// Whether a value of this node's type can stand here.
    fn suits(&self, node: &Node) -> bool {
        let types = self.reachable_types();
        types.is_empty() || types.iter().any(|name| is_of_type(node, name))
    }

    fn names(&self, table: Option<&Table>) -> bool {
        table.is_none_or(|table| table.keys().all(|key| !matches!(self.property(key), Property::Unknown)))
    }

    /// The fixed strings that may stand here, of all alternatives; empty when any string may.
    pub(super) fn words(&self) -> Vec<&'a str> {
        let own = self.all("const").filter_map(Json::as_str);
        let listed = self.all("enum").filter_map(Json::as_array).flatten().filter_map(Json::as_str);
        let mut words: Vec<&str> = own.chain(listed).collect();
        if words.is_empty() {
            words = self.alternatives().into_iter().flatten().flat_map(|shape| shape.words()).collect();
        }
        words
    }

    /// What stands under `key`.
    pub(super) fn property(&self, key: &str) -> Property<'a> {
        let declared = self.all("properties").find_map(|properties| properties.get(key));
        if let Some(schema) = declared {
            return Property::Declared(Self::of(self.root, schema));
        }
        let mut closed = false;
        for layer in &self.layers {
            match layer.get("additionalProperties").or_else(|| layer.get("unevaluatedProperties")) {
                Some(Json::Bool(false)) => closed = true,
                Some(Json::Bool(true)) => return Property::Open(self.anything()),
                Some(schema) => return Property::Free(Self::of(self.root, schema)),
                // serde drops what a struct does not declare; a config that says more than is read is a mistake
                None => closed |= layer.contains_key("properties"),
            }
        }
        if closed { Property::Unknown } else { Property::Open(self.anything()) }
    }

    fn anything(&self) -> Shape<'a> {
        Shape { root: self.root, layers: Vec::new() }
    }

    /// Whether the entries of a table here are named freely, all of one shape.
    pub(super) fn is_map(&self) -> bool {
        let shape = match self.alternatives().as_deref() {
            Some([only]) => self.with(only),
            _ => self.clone(),
        };
        shape.all("properties").next().is_none() && shape.all("additionalProperties").any(Json::is_object)
    }

    /// The declared keys with their schemas.
    pub(super) fn declared(&self) -> impl Iterator<Item = (&'a String, &'a Json)> + '_ {
        self.all("properties").filter_map(Json::as_object).flatten()
    }

    /// What stands at `index` of a list.
    pub(super) fn item(&self, index: usize) -> Option<Shape<'a>> {
        let fixed = self.all("prefixItems").find_map(|items| items.get(index));
        fixed.or_else(|| self.all("items").find(|items| items.is_object())).map(|items| Self::of(self.root, items))
    }

    /// Whether `node`, a string or a list of strings, may stand here as it is, naming no part.
    pub(super) fn takes_words(&self, node: &Node) -> bool {
        match &node.value {
            Value::Text(_) => self.suits(node),
            Value::List(items) => {
                self.suits(node)
                    && items.iter().enumerate().all(|(index, item)| match self.fit(node).ok() {
                        Some(shape) => shape.item(index).is_none_or(|shape| shape.takes_words(item)),
                        None => false,
                    })
            }
            _ => false,
        }
    }
}

/// Whether a value is of a type that JSON schema calls `name`; an integer is a number too.
pub(super) fn is_of_type(node: &Node, name: &str) -> bool {
    match &node.value {
        Value::Flag(_) => name == "boolean",
        Value::Integer(_) => matches!(name, "integer" | "number"),
        Value::Number(_) => name == "number",
        Value::Text(_) => name == "string",
        Value::List(_) => name == "array",
        Value::Table(_) => name == "object",
    }
}

/// The key whose constant tells all alternatives apart, and its value in each.
fn tags<'a>(alternatives: &[Shape<'a>]) -> Option<(&'a str, Vec<&'a str>)> {
    let value = |shape: &Shape<'a>, tag: &str| {
        shape.declared().find(|(key, _)| *key == tag).and_then(|(_, schema)| schema.get("const")).and_then(Json::as_str)
    };
    let candidates = alternatives.first()?.declared().filter(|(_, schema)| schema.get("const").is_some());
    candidates
        .map(|(tag, _)| tag.as_str())
        .find_map(|tag| Some((tag, alternatives.iter().map(|shape| value(shape, tag)).collect::<Option<Vec<_>>>()?)))
}
