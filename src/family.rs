//! One macro: a table of named parts that a config can choose from, one line a part.

/// Declares an enum of specs tagged by `kind` and its `build`, which turns any of them into one trait object.
///
/// `Name builds Box<dyn Trait> { Variant(path::Spec), … }`: each spec needs `fn build(self) -> anyhow::Result<impl Trait>`.
macro_rules! family {
    ($(#[$doc:meta])* $name:ident builds $object:ty { $($variant:ident($spec:ty)),* $(,)? }) => {
        $(#[$doc])*
        #[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
        #[serde(tag = "kind", rename_all = "snake_case")]
        pub enum $name { $(#[allow(missing_docs)] $variant($spec)),* }

        impl $name {
            /// Builds the part that this table describes.
            ///
            /// # Errors
            /// A sentence naming the key whose value is impossible.
            pub fn build(self) -> anyhow::Result<$object> {
                match self { $(Self::$variant(spec) => Ok(Box::new(spec.build()?)),)* }
            }
        }
    };
}
