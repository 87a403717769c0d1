//! Which sources this program was built from.
use std::process::Command;

/// The commit of the sources this program was built from, `-dirty` when they have changed since; empty outside a checkout.
///
/// What lies in `paper/` is made by this program and does not count as a change.
pub fn commit() -> String {
    let git = |words: &[&str]| {
        let output = Command::new("git").args(["-C", env!("CARGO_MANIFEST_DIR")]).args(words).output().ok()?;
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    let Some(head) = git(&["rev-parse", "--short", "HEAD"]) else { return String::new() };
    let changed = git(&["status", "--porcelain", "--untracked-files=no", "--", ".", ":!paper"]);
    if changed.is_some_and(|changed| changed.is_empty()) { head } else { head + "-dirty" }
}
