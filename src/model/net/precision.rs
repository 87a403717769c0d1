//! Which numbers a network's predictions are computed in.
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Numbers that the factors of products between hidden layers are rounded to where nothing is trained: in predictions, and in their
/// derivatives by the input. What weights' derivatives go back through is in f32.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Precision {
    /// f32.
    #[default]
    Single,
    /// bfloat16, sums in f32; several times as fast on processors with a matrix unit (Intel 2023, Advanced Matrix Extensions), each
    /// factor wrong by at most 2⁻⁹. What the network reads and its last layer stay in f32. A derivative is that of the unrounded network
    /// where the rounded one went, its own products rounded too.
    Bfloat16,
}

impl Precision {
    /// Whether this is what configs leave unsaid.
    pub fn is_default(&self) -> bool {
        *self == Self::default()
    }
}
