//! The clock of one thread, which others on the machine do not turn.
use anyhow::Context;

/// Time that this thread has spent computing \[s\].
///
/// # Errors
/// When the system is not Linux.
pub(crate) fn cpu_seconds() -> anyhow::Result<f64> {
    let path = "/proc/thread-self/schedstat";
    let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {path}: CPU time needs Linux"))?;
    let first = text.split_whitespace().next().and_then(|n| n.parse::<f64>().ok());
    Ok(first.with_context(|| format!("{path} holds no number"))? * 1e-9)
}
