//! Runs an experiment: `cargo xtask ablate` passes its arguments on to this program.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use clap::Parser;
use halflight_lab::ablate::bundled::EXPERIMENTS;
use halflight_lab::ablate::provenance::Provenance;
use halflight_lab::ablate::run::{Places, run};
use halflight_lab::ablate::{AblateError, Experiment, output};

/// Sets speed against accuracy: renders every row of an experiment, and writes results.csv, charts and report.html.
///
/// A run that was stopped goes on where it was when started again.
#[derive(Parser)]
#[command(name = "cargo xtask ablate", version)]
struct Arguments {
    /// A bundled experiment or the path of an experiment file
    #[arg(default_value = "default")]
    name: String,
    /// Scene in place of the experiment's: a bundled name or the path of a scene file; may be repeated
    #[arg(long, value_name = "NAME-OR-PATH")]
    scene: Vec<String>,
    /// Image size in place of the experiment's, or of all of them
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<[u32; 2]>,
    /// Small images and one timed frame: checks that everything works
    #[arg(long)]
    quick: bool,
    /// Folder for the output [default: target/ablate/NAME]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Lists the bundled experiments
    #[arg(long)]
    list: bool,
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let sides =
        text.split_once('x').and_then(|(width, height)| Some([width.parse().ok()?, height.parse().ok()?]));
    sides
        .filter(|sides| !sides.contains(&0))
        .ok_or_else(|| "expected WxH in pixels, such as 1280x960".to_string())
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let result = if arguments.list { list() } else { ablate(&arguments) };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(fault) => {
            eprintln!("error: {fault}");
            let mut source = std::error::Error::source(&fault);
            while let Some(cause) = source {
                eprintln!("  because: {cause}");
                source = cause.source();
            }
            ExitCode::FAILURE
        }
    }
}

fn list() -> Result<(), AblateError> {
    for (name, text) in EXPERIMENTS {
        println!("{name:17} {}", Experiment::parse(text, name)?.title);
    }
    Ok(())
}

fn ablate(arguments: &Arguments) -> Result<(), AblateError> {
    let start = Instant::now();
    let mut experiment = Experiment::resolve(&arguments.name)?;
    if arguments.quick {
        experiment.make_quick();
    }
    if let Some(size) = arguments.size {
        experiment.sizes = vec![size];
    }
    if !arguments.scene.is_empty() {
        experiment.set_scenes(&arguments.scene);
    }
    let root = PathBuf::from("target").join("ablate");
    let folder = if arguments.quick { format!("{}-quick", experiment.name) } else { experiment.name.clone() };
    let places = Places {
        out: arguments.out.clone().unwrap_or_else(|| root.join(folder)),
        references: root.join("references"),
    };
    let provenance = Provenance::of_this_run();
    let command = command(arguments, &experiment);
    let outcome = run(&experiment, &places, &provenance, |outcome| {
        output::write(&experiment, outcome, &places, &command)
    })?;
    eprintln!(
        "{} rows in {:.0} s: {}",
        outcome.rows.len(),
        start.elapsed().as_secs_f64(),
        places.out.join("report.html").display()
    );
    Ok(())
}

/// The command that gives this report, without folders: reports are passed on.
fn command(arguments: &Arguments, experiment: &Experiment) -> String {
    let mut command = format!("cargo xtask ablate {}", experiment.name);
    for scene in &arguments.scene {
        let file = PathBuf::from(scene);
        let name = file.file_name().map_or(scene.clone(), |name| name.to_string_lossy().into_owned());
        command += &format!(" --scene {name}");
    }
    if let Some([width, height]) = arguments.size {
        command += &format!(" --size {width}x{height}");
    }
    if arguments.quick {
        command += " --quick";
    }
    command
}
