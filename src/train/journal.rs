//! `metrics.jsonl`: one line per log point, never doubled however often a run is stopped and resumed; and the same for TensorBoard.
use super::events;
use crate::config::write_whole;
use anyhow::Context;
use serde::Serialize;
use std::fs::{File, OpenOptions};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

/// An open journal.
pub(super) struct Journal {
    lines: (PathBuf, File),
    events: (PathBuf, File),
}

const LINES: &str = "metrics.jsonl";
/// TensorBoard reads what has `tfevents` in its name.
const EVENTS: &str = "events.out.tfevents.pliant";

impl Journal {
    /// Opens the files in `folder` for appending after dropping every line whose `step` is beyond `done`, and any torn line; the
    /// events are those of the lines that stay.
    pub(super) fn open(folder: &Path, done: u64) -> anyhow::Result<Self> {
        let (lines, events) = (folder.join(LINES), folder.join(EVENTS));
        let old = match std::fs::read(&lines) {
            Ok(bytes) => String::from_utf8_lossy(&bytes).into_owned(),
            Err(error) if error.kind() == ErrorKind::NotFound => String::new(),
            Err(error) => return Err(error).with_context(|| format!("cannot read {}", lines.display())),
        };
        let written = |line: &str| {
            let line: serde_json::Value = serde_json::from_str(line).ok()?;
            (line["step"].as_u64()? <= done).then_some(line)
        };
        let kept: Vec<(&str, serde_json::Value)> = old.lines().filter_map(|l| Some((l, written(l)?))).collect();
        let text: String = kept.iter().flat_map(|(line, _)| [line, "\n"]).collect();
        write_whole(&lines, text.as_bytes())?;
        let records = kept.iter().flat_map(|(_, line)| events::line(line));
        write_whole(&events, &events::head().into_iter().chain(records).collect::<Vec<u8>>())?;
        Ok(Self { lines: appended(lines)?, events: appended(events)? })
    }

    /// Appends one line.
    pub(super) fn line(&mut self, line: &impl Serialize) -> anyhow::Result<()> {
        let line = serde_json::to_value(line).context("a line of metrics.jsonl cannot be written as JSON")?;
        let append = |(path, file): &mut (PathBuf, File), bytes: &[u8]| {
            file.write_all(bytes).with_context(|| format!("cannot append to {}; is the disk full?", path.display()))
        };
        append(&mut self.lines, format!("{line}\n").as_bytes())?;
        append(&mut self.events, &events::line(&line))
    }
}

fn appended(path: PathBuf) -> anyhow::Result<(PathBuf, File)> {
    let file = OpenOptions::new().append(true).open(&path);
    let file = file.with_context(|| format!("cannot write {}", path.display()))?;
    Ok((path, file))
}
