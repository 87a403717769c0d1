//! How a program ends.
use super::ConfigError;
use crate::watch::{STOPPED, Stopped};
use std::io::Write;
use std::process::ExitCode;

/// Prints what went wrong, if anything, and gives the exit code: 0, 2 for an error, [`STOPPED`] for a stop that was asked for.
///
/// Mistakes in a config are drawn at their line, under the context in which they were met.
pub fn conclude(result: anyhow::Result<()>) -> ExitCode {
    let Err(error) = result else { return ExitCode::SUCCESS };
    if error.downcast_ref::<Stopped>().is_some() {
        eprintln!("{error:#}");
        return ExitCode::from(STOPPED);
    }
    match error.downcast_ref::<ConfigError>() {
        Some(config) => {
            let context = error.to_string();
            if context != config.to_string() {
                eprintln!("error: {context}");
            }
            eprint!("{}", config.graphical());
        }
        None => eprintln!("error: {error:#}"),
    }
    ExitCode::from(2)
}

/// Writes `text` to standard output; a reader that has gone away (`| head`) ends the program quietly.
///
/// # Errors
/// When it cannot be written for another reason.
pub fn to_stdout(text: &str) -> anyhow::Result<()> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => std::process::exit(0),
        written => Ok(written?),
    }
}
