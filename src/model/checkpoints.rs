//! Which states of a rollout its gradient keeps.
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Which states of a rollout of H steps are kept on the way forward; those between are computed again on the way back.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Checkpoints {
    /// Every one: memory O(H), no step is taken twice.
    #[default]
    Every,
    /// One in `s = ⌈√(H + 1)⌉`, and s more at a time on the way back: memory O(√H) for at most one more rollout, and the same gradient
    /// bit for bit (Griewank & Walther 2000, of one level).
    Root,
}

impl Checkpoints {
    /// Whether this is what configs leave unsaid.
    pub fn is_default(&self) -> bool {
        *self == Self::default()
    }

    /// Steps from one kept state to the next, in a rollout of `horizon` steps.
    pub(super) fn stride(self, horizon: usize) -> usize {
        match self {
            Self::Every => 1,
            Self::Root => horizon.isqrt() + 1,
        }
    }
}
