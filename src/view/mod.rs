//! Episodes and rollouts as one HTML page that plays in a browser: no server, no network, nothing to install.
//!
//! The page carries the recorded numbers, a small WebGL renderer and the graph policy of [`crate::graph`] in JavaScript; it also
//! carries edge counts made by [`crate::graph`] itself, compares them with its own, and says so where they differ.
mod edges;
mod facets;
mod page;
mod playback;
mod prediction;

pub use playback::Playback;
pub use prediction::Prediction;

use crate::config::{same_place, write_whole};
use anyhow::ensure;
use std::path::{Path, PathBuf};

impl Playback {
    /// Writes the page that plays the recording, and a model's prediction over it, to `to` or else beside the episode, and returns
    /// its path.
    ///
    /// # Errors
    /// When `to` is the episode itself, or cannot be written.
    pub fn write_page(&self, prediction: Option<&Prediction>, to: Option<&Path>) -> anyhow::Result<PathBuf> {
        let to = to.map_or_else(|| self.path.with_extension("html"), Path::to_owned);
        ensure!(!same_place(&self.path, &to), "{} is the episode itself; name another file with --to", to.display());
        write_whole(&to, page::html(self, prediction).as_bytes())?;
        Ok(to)
    }
}
