//! The `halflight` program: renders scenes, makes references, compares images.

mod args;
mod compare;
mod config;
mod failure;
mod frames;
#[cfg(feature = "gpu")]
mod gpu;
mod info;
mod reference;
mod render;
mod scene;
mod terminal;

use std::process::ExitCode;

use clap::Parser;

use args::{Cli, Command};

/// What a command comes to: messages are for the user, one line each.
type Outcome = Result<(), Box<dyn std::error::Error>>;

fn main() -> ExitCode {
    let outcome = match Cli::parse().command {
        Command::Render(args) => render::run(&args),
        Command::Reference(args) => reference::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Info(args) => info::run(&args),
        Command::Scenes => info::scenes(),
        Command::Completions { shell } => terminal::completions(shell),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            terminal::say(&format!("error: {}", terminal::message(error.as_ref())));
            ExitCode::FAILURE
        }
    }
}
