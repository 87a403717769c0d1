//! The trials that are not done, several at once.
use super::freeze::Frozen;
use super::trial::{Ending, FrozenTrial};
use crate::watch::Watch;
use anyhow::Result;
use indicatif::ProgressBar;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// What has become of the trials of a sweep.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Outcome {
    /// The folder of the sweep.
    pub folder: PathBuf,
    /// Trials that are done, in this run or before.
    pub done: usize,
    /// The folders of the trials that failed in this run.
    pub failed: Vec<PathBuf>,
    /// Trials that another process is running.
    pub elsewhere: usize,
    /// Trials that never started because somebody asked to stop.
    pub left: usize,
}

impl Outcome {
    /// Fails unless every trial is done; a sweep that `watch` stopped ends as every stopped stage does.
    ///
    /// # Errors
    /// A sentence saying how many trials failed, run elsewhere or never started, and what to do.
    pub fn complete(&self, watch: &Watch) -> Result<()> {
        if let Some(first) = self.failed.first() {
            let (count, file) = (self.failed.len(), first.join("failure.json"));
            anyhow::bail!(
                "{count} trials failed, the first as {} says; the same command tries them again",
                file.display()
            );
        }
        let missing = self.elsewhere + self.left;
        if missing == 0 {
            return Ok(());
        }
        let sentence = format!("{missing} trials are not done yet; the same command goes on with them");
        watch.go_on(|| sentence.clone())?;
        anyhow::bail!(sentence)
    }
}

impl std::fmt::Display for Outcome {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { folder, done, failed, elsewhere, left } = self;
        write!(
            f,
            "{done} trials done, {} failed, {elsewhere} running elsewhere, {left} left, in {}",
            failed.len(),
            folder.display()
        )
    }
}

/// Runs every trial that is not done in a process of its own, `jobs` at once, until all ran or `watch` says stop.
///
/// # Errors
/// A file cannot be written: no further trial starts then, and the running ones are waited for.
pub fn launch(frozen: &Frozen, jobs: usize, watch: &Watch) -> Result<Outcome> {
    let bar = watch.stage("trials", frozen.trials.len() as u64);
    let line = Line { frozen, watch, bar, next: AtomicUsize::new(0), broken: AtomicBool::new(false) };
    let endings: Result<Vec<Vec<(&FrozenTrial, Ending)>>> = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..jobs.max(1)).map(|_| scope.spawn(|| line.work())).collect();
        workers.into_iter().map(|worker| worker.join().expect("a worker has no reason to panic")).collect()
    });
    let endings: Vec<(&FrozenTrial, Ending)> = endings?.into_iter().flatten().collect();
    let count = |wanted: Ending| endings.iter().filter(|(_, ending)| *ending == wanted).count();
    let failed = endings.iter().filter(|(_, ending)| *ending == Ending::Failed);
    let mut failed: Vec<PathBuf> = failed.map(|(trial, _)| trial.folder.clone()).collect();
    failed.sort_unstable();
    line.bar.finish();
    Ok(Outcome {
        folder: frozen.folder.clone(),
        done: count(Ending::Done),
        failed,
        elsewhere: count(Ending::Elsewhere),
        left: frozen.trials.len() - endings.len(),
    })
}

/// The trials in line, from which each worker takes the next.
struct Line<'a> {
    frozen: &'a Frozen,
    watch: &'a Watch,
    bar: ProgressBar,
    next: AtomicUsize,
    broken: AtomicBool,
}

impl<'a> Line<'a> {
    fn work(&self) -> Result<Vec<(&'a FrozenTrial, Ending)>> {
        let mut endings = Vec::new();
        while let Some(trial) = self.take() {
            let ending = match trial.done() {
                true => Ending::Done,
                false if self.watch.stopped() || self.broken.load(Ordering::Relaxed) => continue,
                false => trial.run(&self.frozen.command).inspect_err(|_| self.broken.store(true, Ordering::Relaxed))?,
            };
            if ending == Ending::Stopped {
                continue;
            }
            if ending == Ending::Failed {
                self.bar.println(format!("failed: {}", trial.failure().display()));
            }
            endings.push((trial, ending));
            self.bar.inc(1);
        }
        Ok(endings)
    }

    fn take(&self) -> Option<&'a FrozenTrial> {
        self.frozen.trials.get(self.next.fetch_add(1, Ordering::Relaxed))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::watch::Stopped;

    #[test]
    fn a_sweep_cut_short_fails_and_one_that_was_asked_to_stop_says_it_stopped() {
        let outcome = Outcome { folder: PathBuf::from("runs"), done: 1, failed: Vec::new(), elsewhere: 0, left: 2 };
        let watch = Watch::silent();
        let cut_short = outcome.complete(&watch).unwrap_err();
        assert!(cut_short.downcast_ref::<Stopped>().is_none() && cut_short.to_string().contains("2 trials"));
        watch.stop();
        let stopped = outcome.complete(&watch).unwrap_err();
        assert!(stopped.downcast_ref::<Stopped>().is_some() && stopped.to_string().contains("2 trials"));
        assert!(Outcome { left: 0, ..outcome }.complete(&watch).is_ok());
    }
}
