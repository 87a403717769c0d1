//! Episodes and rollouts as one HTML page that plays in a browser: no server, no network, nothing to install.
//!
//! The page carries the recorded numbers, a small WebGL renderer and the graph policy of [`crate::graph`] in JavaScript; it also
//! carries edge counts made by [`crate::graph`] itself, compares them with its own, and says so where they differ. With the Cargo
//! feature `rerun` the same, but for the graph, is written for the Rerun viewer.
mod edges;
mod facets;
mod page;
mod playback;
mod prediction;
#[cfg(feature = "rerun")]
mod rrd;

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
        self.write(&to, page::html(self, prediction).as_bytes())?;
        Ok(to)
    }

    /// Writes the same to `to` as a recording for the Rerun viewer.
    ///
    /// # Errors
    /// As [`can_write_rrd`]; when `to` is the episode itself, or cannot be written.
    #[cfg_attr(not(feature = "rerun"), expect(unused_variables))]
    pub fn write_rrd(&self, prediction: Option<&Prediction>, to: &Path) -> anyhow::Result<()> {
        can_write_rrd()?;
        #[cfg(feature = "rerun")]
        self.write(to, &rrd::bytes(self, prediction)?)?;
        Ok(())
    }

    /// Writes a file that must not take the episode's place.
    fn write(&self, to: &Path, bytes: &[u8]) -> anyhow::Result<()> {
        ensure!(!same_place(&self.path, to), "{} is the episode itself; name another file to write to", to.display());
        write_whole(to, bytes)
    }
}

/// To be asked before a model is fitted for [`Playback::write_rrd`].
///
/// # Errors
/// Without the Cargo feature `rerun`.
pub fn can_write_rrd() -> anyhow::Result<()> {
    ensure!(cfg!(feature = "rerun"), "this program cannot write for Rerun; build it with `--features rerun`");
    Ok(())
}
