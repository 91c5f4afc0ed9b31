//! Runs an experiment: `cargo xtask ablate` passes its arguments on to this program.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use anyhow::{Error, Result, bail};
use clap::Parser;
use clap::builder::PossibleValuesParser;
use halflight_lab::experiment::Experiment;
use halflight_lab::experiment::bundled::EXPERIMENTS;
use halflight_lab::program::{self, Allocator, message, say};
use halflight_lab::results::{Provenance, Table};
use halflight_lab::run::{Device, Places, Progress, run};
use halflight_lab::{furnished, report, robustness};

#[global_allocator]
static ALLOCATOR: Allocator = Allocator;

/// Sets speed against accuracy: renders every row of an experiment, and writes results.csv, charts and report.html.
///
/// A run that was stopped goes on where it was when started again.
#[derive(Parser)]
#[command(name = "cargo xtask ablate", version)]
struct Arguments {
    /// A bundled experiment, the path of an experiment file, `robustness`: where methods fail, or `furnished`: error targets on other scenes
    #[arg(default_value = "default")]
    name: String,
    /// Scene in place of the experiment's: a bundled name or the path of a scene file; may be repeated
    #[arg(long, value_name = "NAME-OR-PATH")]
    scene: Vec<String>,
    /// Image size in place of the experiment's, or of all of them
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<[u32; 2]>,
    /// Device that renders: a GPU takes a program that was built with it, as `cargo xtask` does when this is given
    #[arg(long, value_name = "DEVICE", default_value = "cpu", value_parser = PossibleValuesParser::new(Device::NAMES))]
    device: String,
    /// Small images and one timed frame: checks that everything works
    #[arg(long)]
    quick: bool,
    /// Folder for the output [default: target/ablate/NAME]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Only this case of `robustness`, beside the easy one that it is held against
    #[arg(long, value_name = "NAME")]
    case: Option<String>,
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
    let run = || if arguments.list { list() } else { ablate(&arguments) };
    match program::prepare(None).map_err(Error::msg).and_then(|()| run()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(fault) => {
            say(&format!("error: {}", message(fault.as_ref())));
            ExitCode::FAILURE
        }
    }
}

fn list() -> Result<()> {
    let mut lines = String::new();
    for (name, text) in EXPERIMENTS {
        lines += &format!("{name:17} {}\n", Experiment::parse(text, name)?.title);
    }
    for (name, title) in [(robustness::NAME, robustness::TITLE), (furnished::NAME, furnished::TITLE)] {
        lines += &format!("{name:17} {title}\n");
    }
    program::print(&lines).map_err(Error::msg)
}

fn ablate(arguments: &Arguments) -> Result<()> {
    let start = Instant::now();
    if [robustness::NAME, robustness::OLD_NAME].contains(&arguments.name.as_str()) {
        return robustness(arguments);
    }
    if arguments.case.is_some() {
        bail!("--case is for `robustness` only");
    }
    if arguments.name == furnished::NAME {
        return furnished(arguments);
    }
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
    let places = Places { out: folder(arguments, &experiment.name), references: root().join("references") };
    let device = Device::open(&arguments.device)?;
    if experiment.flicker.is_some() && !matches!(device, Device::Cpu) {
        bail!("flicker is measured on the CPU only: leave out --device");
    }
    if !experiment.indirect.is_empty() && !matches!(device, Device::Cpu) {
        bail!("indirect light is computed on the CPU only: leave out --device");
    }
    let provenance = Provenance::of_this_run(device.name());
    let command = command(arguments, &experiment.name);
    let outcome = run(&experiment, &places, &device, &provenance, |outcome| {
        report::write(&experiment, outcome, &places.out, &command)
    })?;
    say(&format!(
        "{} rows in {:.0} s: {}",
        outcome.rows.len(),
        start.elapsed().as_secs_f64(),
        places.out.join("report.html").display()
    ));
    Ok(())
}

fn robustness(arguments: &Arguments) -> Result<()> {
    if arguments.size.is_some() || !arguments.scene.is_empty() {
        bail!("`robustness` has scenes and sizes of its own: leave out --scene and --size");
    }
    if arguments.device != "cpu" {
        bail!("`robustness` is measured on the CPU only: leave out --device");
    }
    let start = Instant::now();
    let (out, case) = (folder(arguments, robustness::NAME), arguments.case.as_deref());
    let begins = |prefix: &str| case.is_some_and(|name| name.starts_with(prefix));
    let (of_indirect, of_gloss) = (begins(robustness::indirect::PREFIX), begins(robustness::glossy::PREFIX));
    let provenance = Provenance::of_this_run(Device::Cpu.name());
    fs_err::create_dir_all(&out)?;
    let written = |table: Table, name: &str, kind: &str| -> Result<()> {
        table.write_csv(&out.join(name))?;
        say(&format!("{} pictures of {kind}: {}", table.lines.len(), out.join(name).display()));
        Ok(())
    };
    if of_indirect || case.is_none() {
        let progress = Progress::new(0, 0);
        let rows = robustness::indirect::run(case, &progress)?;
        progress.finish();
        written(robustness::indirect::table(&rows, &provenance), "indirect.csv", "indirect light")?;
    }
    if of_gloss || case.is_none() {
        let progress = Progress::new(0, 0);
        let rows = robustness::glossy::run(case, &progress)?;
        progress.finish();
        written(robustness::glossy::table(&rows, &provenance), "glossy.csv", "glossy surfaces")?;
    }
    if of_indirect || of_gloss {
        return Ok(());
    }
    let plan = robustness::Plan::new(case, arguments.quick)?;
    let rows = robustness::run(&plan, &out, &Progress::new(plan.pictures(), 0))?;
    robustness::output::write(&rows, &out, &provenance, &command(arguments, robustness::NAME))?;
    say(&format!(
        "{} pictures in {:.0} s: {}",
        plan.pictures(),
        start.elapsed().as_secs_f64(),
        out.join("robustness.html").display()
    ));
    robustness::check(&rows)
}

fn furnished(arguments: &Arguments) -> Result<()> {
    if arguments.device != "cpu" {
        bail!("`furnished` is measured on the CPU only: leave out --device");
    }
    let plan = furnished::Plan::new(&arguments.scene, arguments.size, arguments.quick);
    let out = folder(arguments, furnished::NAME);
    let progress = Progress::new(plan.rows() as u64, 0);
    let rows = furnished::run(&plan, &root().join("references"), &out, &progress)?;
    progress.finish();
    furnished::table(&rows, &Provenance::of_this_run(Device::Cpu.name()))
        .write_csv(&out.join("furnished.csv"))?;
    say(&furnished::summary(&rows));
    say(&format!("{} rows: {}", rows.len(), out.join("furnished.csv").display()));
    Ok(())
}

/// Returns the folder that experiments write to.
fn root() -> PathBuf {
    PathBuf::from("target").join("ablate")
}

/// Returns the folder that this experiment writes to.
fn folder(arguments: &Arguments, name: &str) -> PathBuf {
    let device = if arguments.device == "cpu" { String::new() } else { format!("-{}", arguments.device) };
    let folder = format!("{name}{device}{}", if arguments.quick { "-quick" } else { "" });
    arguments.out.clone().unwrap_or_else(|| root().join(folder))
}

/// Returns the command that gives this report, without folders: reports are passed on.
fn command(arguments: &Arguments, name: &str) -> String {
    let mut command = format!("cargo xtask ablate {name}");
    if let Some(case) = &arguments.case {
        command += &format!(" --case {case}");
    }
    for scene in &arguments.scene {
        let file = PathBuf::from(scene);
        let name = file.file_name().map_or(scene.clone(), |name| name.to_string_lossy().into_owned());
        command += &format!(" --scene {name}");
    }
    if let Some([width, height]) = arguments.size {
        command += &format!(" --size {width}x{height}");
    }
    if arguments.device != "cpu" {
        command += &format!(" --device {}", arguments.device);
    }
    if arguments.quick {
        command += " --quick";
    }
    command
}
