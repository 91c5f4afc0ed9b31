//! Start, messages and errors of all programs: results go to standard output, everything else to standard error.

use std::error::Error;
use std::io::{self, Write};

use rayon::ThreadPoolBuilder;

pub use allocator::Allocator;

mod allocator;

/// Starts the worker threads, `asked` for by the user or by the environment, and says so where they are fewer. From then on
/// writing beyond the limit on file sizes (`ulimit -f`) is an error and no longer the end of the program.
///
/// # Errors
/// The threads cannot be started.
pub fn prepare(asked: Option<usize>) -> Result<(), String> {
    #[cfg(unix)]
    // SAFETY: no handler is installed, and no other thread runs yet.
    unsafe {
        libc::signal(libc::SIGXFSZ, libc::SIG_IGN);
    }
    let asked = asked.or_else(|| std::env::var("RAYON_NUM_THREADS").ok()?.parse().ok()).unwrap_or(0);
    let threads = halflight_cpu::pipeline::useful_threads(asked);
    if threads < asked {
        say(&format!("{threads} threads are used instead of {asked}: more would only wait for each other"));
    }
    let started = ThreadPoolBuilder::new().num_threads(threads).build_global();
    started.map_err(|error| format!("worker threads cannot be started: {error}"))
}

/// Prints a result. A reader that has gone away (`| head`) has seen enough: no error.
///
/// # Errors
/// A message about standard output.
pub fn print(text: &str) -> Result<(), String> {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(format!("cannot write to standard output: {error}"))
        }
        _ => Ok(()),
    }
}

/// Prints a message to standard error, where there is one.
pub fn say(text: &str) {
    // Nobody is left to tell that messages cannot be written.
    let _ = writeln!(io::stderr().lock(), "{text}");
}

/// Returns an error with its causes, as far as it does not name them itself.
pub fn message(error: &dyn Error) -> String {
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
