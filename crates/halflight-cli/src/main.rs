//! The `halflight` program: renders scenes, makes references, compares images.

mod animate;
mod args;
mod compare;
mod config;
mod info;
mod job;
mod moment;
mod output;
mod paths;
mod reference;
mod render;
mod scene;
mod statistics;
mod voxel_errors;

use std::process::ExitCode;

use clap::Parser;

use args::{Cli, Command};
use halflight_lab::program::{self, Allocator};

#[global_allocator]
static ALLOCATOR: Allocator = Allocator;

/// Name and version, as stored in images.
const PROGRAM: &str = concat!("halflight ", env!("CARGO_PKG_VERSION"));

/// Commit that the program was built from; `None` outside of a repository.
const COMMIT: Option<&str> = option_env!("HALFLIGHT_COMMIT");

/// Result of a command; messages of errors are for the user, one line each.
type Outcome = Result<(), Box<dyn std::error::Error>>;

fn main() -> ExitCode {
    let outcome = run(Cli::parse().command);
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            program::say(&format!("error: {}", program::message(error.as_ref())));
            ExitCode::FAILURE
        }
    }
}

fn run(command: Command) -> Outcome {
    let threads = match &command {
        Command::Render(args) => args.threads,
        Command::Reference(args) => args.threads,
        _ => None,
    };
    program::prepare(threads.map(usize::from))?;
    match command {
        Command::Render(args) => job::run(*args),
        Command::Reference(args) => reference::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Info(args) => info::run(&args),
        Command::Scenes => info::scenes(),
        Command::Completions { shell } => info::completions(shell),
    }
}
