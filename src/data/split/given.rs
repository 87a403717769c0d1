//! Held out as the recordings themselves say.
use super::{DatasetSpec, Entry, Episode, HoldOut};
use anyhow::bail;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The episodes that their source calls validation or test are held out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GivenSpec {}

/// What a source says an episode is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Part {
    /// To learn from.
    Train,
    /// To judge by.
    HeldOut,
}

impl GivenSpec {
    /// Nothing to check before the dataset is known.
    ///
    /// # Errors
    /// Never.
    pub fn build(self) -> anyhow::Result<impl HoldOut> {
        Ok(self)
    }
}

impl HoldOut for GivenSpec {
    fn held_out(&self, _: &[Episode], entries: &[Entry], _: f64) -> Vec<bool> {
        entries.iter().map(|entry| entry.part == Some(Part::HeldOut)).collect()
    }

    fn check(&self, _: &DatasetSpec) -> anyhow::Result<()> {
        bail!("`split.kind` is \"given\", which is for imported recordings; simulated episodes say nothing themselves")
    }
}
