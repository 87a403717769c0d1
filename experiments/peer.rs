//! Another project's program, run on a scene of ours in the same run.
use crate::claim::chosen;
use anyhow::{Context, ensure};
use serde_json::Value;
use std::path::Path;
use std::process::Command;

/// A Python interpreter that has the peers.
pub(crate) struct Peer(String);

impl Peer {
    /// The interpreter that `python=PATH` among `words` names, else `python3`.
    ///
    /// # Errors
    /// When a word is another one.
    pub(crate) fn named(words: &[String]) -> anyhow::Result<Self> {
        Ok(Self(chosen(words, "python", "python3")?))
    }

    /// The JSON lines that `experiments/peers/SCRIPT` prints for `scene`.
    ///
    /// # Errors
    /// When it cannot be run, fails, or prints something else: a sentence with what it said.
    pub(crate) fn run(&self, script: &str, scene: &Value) -> anyhow::Result<Vec<Value>> {
        let path = Path::new("experiments/peers").join(script);
        let file = std::env::temp_dir().join(format!("pliant-{}.json", std::process::id()));
        std::fs::write(&file, scene.to_string()).with_context(|| format!("cannot write {}", file.display()))?;
        let output = Command::new(&self.0).arg(&path).arg(&file).output();
        let removed = std::fs::remove_file(&file);
        let output = output.with_context(|| format!("cannot run `{}`; name an interpreter by python=PATH", self.0))?;
        removed.with_context(|| format!("cannot remove {}", file.display()))?;
        let said = String::from_utf8_lossy(&output.stderr);
        ensure!(
            output.status.success(),
            "{} failed under `{}`; its first lines say what to install, and it said: {}",
            path.display(),
            self.0,
            said.lines().last().unwrap_or("nothing")
        );
        let lines = String::from_utf8_lossy(&output.stdout);
        let rows: Result<Vec<Value>, _> = lines.lines().map(serde_json::from_str).collect();
        rows.with_context(|| format!("{} printed something else than JSON lines", path.display()))
    }
}
