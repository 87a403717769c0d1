//! `metrics.jsonl`: one line per log point, never doubled however often a run is stopped and resumed.
use crate::config::write_whole;
use anyhow::Context;
use serde::Serialize;
use std::fs::{File, OpenOptions};
use std::io::{ErrorKind, Write};
use std::path::Path;

/// An open journal.
pub(super) struct Journal {
    file: File,
}

impl Journal {
    /// Opens `path` for appending after dropping every line whose `step` is beyond `done`, and any torn line.
    pub(super) fn open(path: &Path, done: u64) -> anyhow::Result<Self> {
        let old = match std::fs::read(path) {
            Ok(bytes) => String::from_utf8_lossy(&bytes).into_owned(),
            Err(error) if error.kind() == ErrorKind::NotFound => String::new(),
            Err(error) => return Err(error).with_context(|| format!("cannot read {}", path.display())),
        };
        let written = |line: &&str| {
            let line: Option<serde_json::Value> = serde_json::from_str(line).ok();
            line.and_then(|l| l["step"].as_u64()).is_some_and(|step| step <= done)
        };
        let kept: String = old.lines().filter(written).flat_map(|line| [line, "\n"]).collect();
        write_whole(path, kept.as_bytes())?;
        let file = OpenOptions::new().append(true).open(path);
        Ok(Self { file: file.with_context(|| format!("cannot write {}", path.display()))? })
    }

    /// Appends one line.
    pub(super) fn line(&mut self, line: &impl Serialize) -> anyhow::Result<()> {
        let mut text = serde_json::to_string(line).context("a line of metrics.jsonl cannot be written as JSON")?;
        text.push('\n');
        self.file.write_all(text.as_bytes()).context("cannot append to metrics.jsonl; is the disk full?")
    }
}
