//! How a long stage shows its progress and hears that it should stop.
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Handed to every stage that may take more than a second.
#[derive(Clone, Debug, Default)]
pub struct Watch {
    stop: Arc<AtomicBool>,
    visible: bool,
}

/// Exit code of a program that ended because it was asked to stop: that of a shell's own Ctrl-C.
pub const STOPPED: u8 = 130;

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

    /// Draws bars, and stops at Ctrl-C: the first asks every stage to save and return, a second one ends the program at once.
    pub fn listening() -> Self {
        let watch = Self::visible();
        let stop = watch.clone();
        // Without a handler Ctrl-C merely ends the run, which resumes from its last checkpoint all the same.
        let _ = ctrlc::set_handler(move || {
            if stop.stopped() {
                std::process::exit(STOPPED.into());
            }
            eprintln!("stopping after saving; press Ctrl-C again to stop at once");
            stop.stop();
        });
        watch
    }

    /// Asks every stage to save what it has and return.
    pub fn stop(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }

    /// Fails with [`Stopped`] and a sentence of what was saved when somebody asked to stop.
    ///
    /// # Errors
    /// [`Stopped`].
    pub fn go_on(&self, saved: impl FnOnce() -> String) -> Result<(), Stopped> {
        if self.stopped() { Err(Stopped(saved())) } else { Ok(()) }
    }

    /// Whether somebody asked to stop.
    pub fn stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

/// A stage ended early because somebody asked it to; what it had is saved.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Stopped(String);

impl fmt::Display for Stopped {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Stopped {}
