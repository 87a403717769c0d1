//! One trial: its folder, its lock, its one run.
use crate::config::write_whole;
use crate::watch::STOPPED;
use anyhow::{Context, Result};
use indexmap::IndexMap;
use serde::{Deserialize, Serialize};
use serde_json::{Value as Json, json};
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// So many last lines of the log are kept in `failure.json`.
const LAST_LINES: usize = 20;
/// And they are sought in so many last bytes of it.
const LAST_BYTES: u64 = 64 << 10;

/// What is remembered about a trial beside its config.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Record {
    pub(super) change: String,
    pub(super) overrides: IndexMap<String, Json>,
}

/// A trial whose config is written down.
#[derive(Clone, Debug)]
pub struct FrozenTrial {
    /// Its folder, named by the fingerprint of its config.
    pub folder: PathBuf,
    result: PathBuf,
}

/// How running a trial went.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ending {
    /// Its result is there.
    Done,
    /// It failed, as `failure.json` says.
    Failed,
    /// It saved what it had and stopped because it was asked to.
    Stopped,
    /// Another process is running it.
    Elsewhere,
}

impl FrozenTrial {
    pub(super) fn of(sweep: &Path, name: &str, result: &str) -> Self {
        let folder = sweep.join(name);
        Self { result: folder.join(result), folder }
    }

    /// Its resolved config.
    pub fn config(&self) -> PathBuf {
        self.folder.join("config.toml")
    }

    /// The file that holds its rows once it is done.
    pub fn result(&self) -> &Path {
        &self.result
    }

    /// Whether it is done.
    pub fn done(&self) -> bool {
        self.result.exists()
    }

    /// Why it failed the last time, if it did.
    pub fn failure(&self) -> PathBuf {
        self.folder.join("failure.json")
    }

    /// Runs the trial unless it is done or runs elsewhere.
    pub(super) fn run(&self, command: &[String]) -> Result<Ending> {
        let Some(lock) = self.lock()? else { return Ok(Ending::Elsewhere) };
        let ending = if self.done() { Ok(Ending::Done) } else { self.run_locked(&lock, command) };
        // closing would not do: a process that another thread is just starting holds a copy until it has started
        lock.unlock()?;
        ending
    }

    fn run_locked(&self, lock: &File, command: &[String]) -> Result<Ending> {
        let log_path = self.folder.join("log.txt");
        let log = File::create(&log_path).with_context(|| format!("cannot write `{}`", log_path.display()))?;
        let [program, words @ ..] = command else { anyhow::bail!("`command` is empty: name a program to run") };
        let run = Command::new(program)
            .args(words)
            .arg(self.config())
            .arg(format!("out={}", self.folder.display()))
            // the child shares the lock through its standard input: should this process be killed, the trial stays
            // locked until the child ends too
            .stdin(Stdio::from(lock.try_clone()?))
            .stdout(Stdio::from(log.try_clone()?))
            .stderr(Stdio::from(log))
            .status();
        let (code, why) = match run {
            Ok(status) if status.success() && self.done() => {
                let _ = fs::remove_file(self.failure());
                return Ok(Ending::Done);
            }
            Ok(status) if status.code() == Some(STOPPED.into()) => return Ok(Ending::Stopped),
            Ok(status) if status.success() => {
                (status.code(), format!("it ended without writing `{}`", self.result.display()))
            }
            Ok(status) => (status.code(), status.to_string()),
            Err(error) => (None, format!("cannot start `{program}`: {error}")),
        };
        // rows that a failed run left are not the rows of a whole one
        if self.done() {
            fs::rename(&self.result, self.result.with_added_extension("partial"))?;
        }
        let failure = json!({ "why": why, "code": code, "command": command, "log": last_lines(&log_path) });
        write_whole(&self.failure(), format!("{failure:#}\n").as_bytes())?;
        Ok(Ending::Failed)
    }

    /// The lock on this trial, or nothing when another process holds it.
    ///
    /// The system frees it when its holders end, however they end, so it is never stale; the process id in the file is
    /// for people.
    fn lock(&self) -> Result<Option<File>> {
        let path = self.folder.join("lock");
        let sentence = || format!("cannot lock `{}`", path.display());
        let mut options = OpenOptions::new();
        let mut file =
            options.read(true).write(true).create(true).truncate(false).open(&path).with_context(sentence)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Ok(None),
            Err(TryLockError::Error(error)) => return Err(error).with_context(sentence),
        }
        file.set_len(0)?;
        writeln!(file, "{}", std::process::id())?;
        Ok(Some(file))
    }
}

fn last_lines(log: &Path) -> Vec<String> {
    let mut bytes = Vec::new();
    let read = File::open(log).and_then(|mut file| {
        let length = file.metadata()?.len();
        file.seek(SeekFrom::Start(length.saturating_sub(LAST_BYTES)))?;
        file.read_to_end(&mut bytes)
    });
    if let Err(error) = read {
        return vec![format!("cannot read `{}`: {error}", log.display())];
    }
    let text = String::from_utf8_lossy(&bytes);
    let lines: Vec<&str> = text.lines().collect();
    lines[lines.len().saturating_sub(LAST_LINES)..].iter().map(|line| (*line).to_owned()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trial_that_another_sweep_finished_meanwhile_is_not_run_again() {
        let folder = tempfile::TempDir::new().unwrap();
        let trial = FrozenTrial { result: folder.path().join("rows.jsonl"), folder: folder.path().to_owned() };
        let command = ["/nonexistent/program".to_owned()];
        fs::write(&trial.result, "").unwrap();
        assert_eq!(trial.run(&command).unwrap(), Ending::Done);
        assert!(!trial.failure().exists());
        fs::remove_file(&trial.result).unwrap();
        assert_eq!(trial.run(&command).unwrap(), Ending::Failed);
    }
}
