//! How a long stage shows its progress and hears that it should stop.
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Handed to every stage that may take more than a second.
#[derive(Clone, Debug, Default)]
pub struct Watch {
    stop: Arc<AtomicBool>,
    visible: bool,
}

impl Watch {
    /// Shows nothing and never stops: for tests and for work inside other work.
    pub fn silent() -> Self {
        Self::default()
    }

    /// Draws bars on stderr.
    pub fn visible() -> Self {
        Self { visible: true, ..Self::default() }
    }

    /// A bar for `length` units of work called `name`, with rate and remaining time.
    pub fn stage(&self, name: &str, length: u64) -> ProgressBar {
        let target = if self.visible { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        let style = ProgressStyle::with_template("{prefix:>22} {bar:30} {pos}/{len} {per_sec} eta {eta} {msg}");
        ProgressBar::with_draw_target(Some(length), target)
            .with_style(style.expect("a constant template"))
            .with_prefix(name.to_owned())
    }

    /// Asks every stage to save what it has and return.
    pub fn stop(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }

    /// Whether somebody asked to stop.
    pub fn stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}
