//! Configs: TOML files with `extends` and named parts, command-line overrides, and errors that point at the line.
//!
//! ```toml
//! extends = "default"               # another file of this folder, or a list of them; this file is laid on top
//! planner = "cem"                   # the contents of configs/planner/cem.toml
//! model = ["learned", "still"]      # a table of parts: model.learned, model.still
//!
//! [model.learned.train]             # single keys of a part
//! steps = 500
//! ```
//!
//! Any key can be changed on the command line: `planner=mppi`, `planner.samples=256`, `+model.mine={extends=learned}`,
//! `~model.still`. Whatever names a part is applied before parts are read and everything else after, so their order
//! matters only where two change the same key.
mod compose;
mod conclude;
mod error;
mod fingerprint;
mod group;
mod hold;
mod merge;
mod overrides;
mod parse;
mod print;
mod resolved;
mod shape;
mod source;
mod suggest;
mod tree;
mod validate;
mod whole_file;
mod word;

use compose::Composer;
use group::{Groups, shown};
use overrides::Override;
use schemars::JsonSchema;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value as Json;
use shape::Shape;
use std::path::Path;

pub(crate) use overrides::{assignment, meaning};
pub(crate) use suggest::nearest;

pub use conclude::{conclude, to_stdout};
pub use error::ConfigError;
pub use fingerprint::{Fingerprint, fingerprint};
pub use group::stems;
pub use hold::{hold, vacate};
pub use resolved::Resolved;
pub use whole_file::{same_place, write_whole};

/// A type that a config can be loaded into.
pub trait Spec: Serialize + DeserializeOwned + JsonSchema {}

impl<T: Serialize + DeserializeOwned + JsonSchema> Spec for T {}

/// A config as a value, and as a text that knows where everything came from.
#[derive(Clone, Debug)]
pub struct Loaded<T> {
    /// The value.
    pub spec: T,
    /// The same, with the origin of each part.
    pub resolved: Resolved,
}

/// Loads a config: the file on top of what it extends, changed by the overrides, named parts read, checked against the
/// JSON schema of `T`, defaults filled in.
///
/// # Errors
/// A file is missing or is not TOML, configs extend each other in a circle, a part, key or kind is unknown, a key is
/// missing, a value has the wrong type or is out of range, an override is not understood. The error points at the place.
pub fn load<T: Spec>(path: &Path, overrides: &[String]) -> Result<Loaded<T>, ConfigError> {
    let schema = schema_json::<T>();
    let shape = Shape::top(&schema);
    let mut composer = Composer::new(Groups::around(path));
    let mut root = composer.layered(&shown(path), None)?;

    let parsed: Result<Vec<Override>, _> =
        overrides.iter().map(|text| Override::parse(text, &mut composer.sources)).collect();
    let (mut selections, changes): (Vec<_>, Vec<_>) = parsed?.into_iter().partition(|it| it.selects(&composer.groups));
    selections.sort_by_key(Override::depth);
    for selection in selections {
        selection.apply(&mut root, &composer.groups, &composer.sources)?;
    }
    root = composer.resolve(root, "", Some(&shape))?;
    for change in changes {
        change.apply(&mut root, &composer.groups, &composer.sources)?;
    }
    // a change may itself bring parts: `+model.mine={extends=learned}`
    root = composer.resolve(root, "", Some(&shape))?;

    validate::validate(&root, &shape, &composer.sources)?;
    let spec: T = serde_path_to_error::deserialize(root.to_json()).map_err(|error| {
        let key = error.path().to_string();
        let here = Resolved::filled(&root.to_json(), &root, composer.sources.clone());
        ConfigError::at(&here, &key, format!("`{key}`: {}", error.inner()))
    })?;
    let resolved = Resolved::filled(&spec, &root, composer.sources);
    Ok(Loaded { spec, resolved })
}

/// The JSON schema of a config, for editors and for reading.
pub fn schema<T: Spec>() -> String {
    format!("{:#}", schema_json::<T>())
}

fn schema_json<T: Spec>() -> Json {
    schemars::schema_for!(T).to_value()
}
