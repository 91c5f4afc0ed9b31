//! Tasks of the workspace: `cargo xtask …`. Thin: the programs do the work.

use std::process::{Command, ExitCode};

const USAGE: &str = "\
cargo xtask TASK

  ablate [NAME] [--scene NAME-OR-PATH]… [--size WxH] [--device gpu] [--quick] [--out DIR] [--list]
      runs an experiment (`default` where none is named) and writes results.csv, charts and report.html
      to target/ablate/NAME; --help says more
  gpu-bench [--scene NAME-OR-PATH]… [--quick] [--out DIR]
      the experiment `gpu` on the GPU: every stage that it has, stage by stage. Built once with
      `cargo build --release -p halflight-lab --features gpu`, it starts what is built and needs no network
  ablate robustness [--case NAME] [--quick] [--out DIR]
      every combination of stages in awkward cases: what passes, is degraded or fails, why, and what mends it; fails
      where a picture is not finite, negative or not there
  exactness [--scene NAME-OR-PATH]… [--pairs N] [--brute-force N] [--certificates N] [--seed N] [--out DIR]
      compares the masks of the exact visibility backends bit for bit and with brute force, tries to break what beams
      certify, and fails where anything differs; --help says more
";

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    match arguments.next().as_deref() {
        Some(task @ ("ablate" | "exactness")) => {
            let arguments: Vec<String> = arguments.collect();
            let gpu = arguments.iter().any(|argument| argument == "gpu" || argument == "--device=gpu");
            run(&format!("halflight-{task}"), gpu && task == "ablate", false, &arguments)
        }
        Some("gpu-bench") => {
            let arguments = ["gpu", "--device", "gpu"].map(str::to_owned).into_iter().chain(arguments);
            run("halflight-ablate", true, true, &arguments.collect::<Vec<_>>())
        }
        Some("help" | "--help" | "-h") => {
            print!("{USAGE}");
            ExitCode::SUCCESS
        }
        task => {
            if let Some(task) = task {
                eprintln!("error: there is no task `{task}`");
            }
            eprint!("{USAGE}");
            ExitCode::FAILURE
        }
    }
}

/// Builds a program of the lab and runs it; without the network, if it must do without.
fn run(program: &str, gpu: bool, offline: bool, arguments: &[String]) -> ExitCode {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(cargo);
    command.args(["run", "--release", "-q", "-p", "halflight-lab", "--bin", program]);
    if gpu {
        command.args(["--features", "gpu"]);
    }
    if offline {
        command.arg("--offline");
    }
    match command.arg("--").args(arguments).status() {
        Ok(status) if status.success() => ExitCode::SUCCESS,
        Ok(_) => ExitCode::FAILURE,
        Err(fault) => {
            eprintln!("error: cargo cannot be started: {fault}");
            ExitCode::FAILURE
        }
    }
}
