//! Text for the user: results to standard output, everything else to standard error.

use std::error::Error;
use std::io::{self, Write};

use clap::CommandFactory;

use crate::Outcome;
use crate::args::Cli;

/// Prints a result. A reader that has gone away (`| head`) has seen enough: no error.
pub(crate) fn print(text: &str) -> Outcome {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(format!("cannot write to standard output: {error}").into())
        }
        _ => Ok(()),
    }
}

/// Prints a message to standard error, where there is one.
pub(crate) fn say(text: &str) {
    // Nobody is left to tell that messages cannot be written.
    let _ = writeln!(io::stderr().lock(), "{text}");
}

/// An error with its causes, as far as it does not name them itself.
pub(crate) fn message(error: &dyn Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        let reason = error.to_string();
        if !text.contains(&reason) {
            text = format!("{text}: {reason}");
        }
        cause = error.source();
    }
    text
}

/// Prints the completions of a shell.
pub(crate) fn completions(shell: clap_complete::Shell) -> Outcome {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "halflight", &mut script);
    print(&String::from_utf8_lossy(&script))
}
