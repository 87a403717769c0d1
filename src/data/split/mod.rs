//! Which episodes are held out: whole episodes, never single frames.
mod episode;
mod given;
mod group;
mod size;

use super::metadata::Entry;
use super::{Dataset, DatasetSpec, Episode};

pub use episode::EpisodeSpec;
pub use given::{GivenSpec, Part};
pub use group::{By, GroupSpec};
pub use size::SizeSpec;

/// Fraction of a dataset's episodes that no fit sees, where the split leaves that open.
pub const HELD_OUT: f64 = 0.2;

/// A rule of what is held out: the same episodes every time.
pub trait HoldOut {
    /// For each of `episodes`, of which `entries` say what they are, whether it is held out; about `fraction` of them where the
    /// rule leaves that open.
    fn held_out(&self, episodes: &[Episode], entries: &[Entry], fraction: f64) -> Vec<bool>;

    /// Refuses a dataset that the rule leaves nothing to learn from or nothing to judge by.
    ///
    /// # Errors
    /// A sentence naming the key.
    fn check(&self, _: &DatasetSpec) -> anyhow::Result<()> {
        Ok(())
    }
}

family! {
    /// The kinds of splits, files in `configs/split`.
    SplitSpec builds Box<dyn HoldOut> {
        Episode(EpisodeSpec), Size(SizeSpec), Group(GroupSpec), Given(GivenSpec),
    }
}

impl Default for SplitSpec {
    fn default() -> Self {
        Self::Episode(EpisodeSpec {})
    }
}

impl SplitSpec {
    /// Whether it is the default, which configs and metadata do not write.
    pub(super) fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

impl Dataset {
    /// `(to learn from, held out)` by the dataset's own rule: of each tool's n episodes every (1/`fraction`)-th unless its spec
    /// says otherwise.
    pub fn split(&self, fraction: f64) -> (Vec<&Episode>, Vec<&Episode>) {
        let held = self.metadata.held_out(&self.episodes, fraction);
        let pick =
            |wanted: bool| self.episodes.iter().zip(&held).filter(|(_, h)| **h == wanted).map(|(e, _)| e).collect();
        (pick(false), pick(true))
    }
}

/// ⌈`fraction` · n⌉, but at most n − 1, so that something is left to learn from.
fn share(fraction: f64, n: usize) -> usize {
    ((fraction.clamp(0.0, 1.0) * n as f64 - 1e-9).ceil() as usize).min(n.saturating_sub(1))
}
