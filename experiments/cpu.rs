//! Clocks of threads, which others on the machine do not turn.
use anyhow::Context;
use std::path::Path;

/// Time that this thread has spent computing \[s\].
///
/// # Errors
/// When the system is not Linux.
pub(crate) fn cpu_seconds() -> anyhow::Result<f64> {
    computed(Path::new("/proc/thread-self"))
}

/// Time that all living threads of this process have spent computing \[s\].
///
/// # Errors
/// When the system is not Linux.
pub(crate) fn process_seconds() -> anyhow::Result<f64> {
    let threads = std::fs::read_dir("/proc/self/task").context("cannot read /proc/self/task: CPU time needs Linux")?;
    threads.map(|thread| computed(&thread?.path())).sum()
}

fn computed(thread: &Path) -> anyhow::Result<f64> {
    let path = thread.join("schedstat");
    let text = std::fs::read_to_string(&path);
    let text = text.with_context(|| format!("cannot read {}: CPU time needs Linux", path.display()))?;
    let first = text.split_whitespace().next().and_then(|n| n.parse::<f64>().ok());
    Ok(first.with_context(|| format!("{} holds no number", path.display()))? * 1e-9)
}
