//! Holds exact backends against each other and against brute force: `cargo xtask exactness` passes its arguments on to
//! this program.

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

use anyhow::{Error, Result};
use clap::Parser;
use halflight_cpu::bvh::Bvh;
use halflight_cpu::prepared::PreparedScene;
use halflight_lab::exactness::certificates::{self, Outcome};
use halflight_lab::exactness::primary::{self, PrimaryAgreement};
use halflight_lab::exactness::{self, Record, SCENES, Settings};
use halflight_lab::program::{self, Allocator, message, say};
use halflight_lab::reference::seen;
use halflight_lab::results::Provenance;
use indicatif::{HumanCount, ProgressBar, ProgressStyle};

#[global_allocator]
static ALLOCATOR: Allocator = Allocator;

/// Compares what pixels see with brute force in double precision, the masks of bvh, raster4d and beam bit for bit and with
/// brute force, and tries to break what beams certify.
///
/// Fails where anything differs.
#[derive(Parser)]
#[command(name = "cargo xtask exactness", version)]
struct Arguments {
    /// A bundled scene or the path of a scene file; may be repeated [default: atrium, nave, hairball, tree, soup]
    #[arg(long, value_name = "NAME-OR-PATH")]
    scene: Vec<String>,
    /// Pairs of a receiver and a light sample that every backend is compared on in each scene
    #[arg(long, value_name = "N", value_parser = count, default_value = "1e7")]
    pairs: u64,
    /// Pairs that are compared with brute force over all triangles in each scene
    #[arg(long, value_name = "N", value_parser = count, default_value = "1e5")]
    brute_force: u64,
    /// Receivers, times triangles of their scene, about which beams must have certified something while attacked; 0 for no
    /// attacks
    #[arg(long, value_name = "N", value_parser = count, default_value = "1e6")]
    certificates: u64,
    /// Only the attacks on what beams certify
    #[arg(long, conflicts_with_all = ["scene", "pairs", "brute_force"])]
    only_certificates: bool,
    /// Side of the square image whose pixels are compared with brute force in each scene; 0 for none
    #[arg(long, value_name = "PIXELS", default_value_t = 480)]
    primary: u16,
    /// Seed of light samples, chosen receivers and attacks
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u32,
    /// Folder for primary.csv, exactness.csv and certificates.csv
    #[arg(long, value_name = "DIR", default_value = "target/exactness")]
    out: PathBuf,
}

/// A number such as 250000 or 1e7.
fn count(text: &str) -> Result<u64, String> {
    let whole = |number: f64| number >= 0.0 && number.fract() == 0.0 && number <= 1e15;
    let float = || text.parse().ok().filter(|&number| whole(number)).map(|number: f64| number as u64);
    text.parse()
        .ok()
        .or_else(float)
        .ok_or_else(|| "expected a whole number, such as 250000 or 1e7".to_string())
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    match program::prepare(None).map_err(Error::msg).and_then(|()| run(&arguments)) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(fault) => {
            say(&format!("error: {}", message(fault.as_ref())));
            ExitCode::FAILURE
        }
    }
}

/// Returns whether nothing differs.
fn run(arguments: &Arguments) -> Result<bool> {
    // Known before hours of work, not after.
    exactness::check_folder(&arguments.out)?;
    let provenance = Provenance::of_this_run("cpu".to_string());
    let mut right = true;
    if !arguments.only_certificates {
        let records = scenes(arguments)?;
        program::print(&exactness::table(&records)).map_err(Error::msg)?;
        let columns = ["scene", "triangles", "bvh_against", "pairs", "different"];
        exactness::write_csv(
            &arguments.out,
            "exactness.csv",
            &columns,
            &records,
            arguments.seed,
            &provenance,
        )?;
        right &= records.iter().all(|record| record.different == 0);
    }
    if !arguments.only_certificates && arguments.primary > 0 {
        let records = primary_hits(arguments)?;
        for (scene, triangles, PrimaryAgreement { pixels, different, open }) in &records {
            println!(
                "{scene:<14} {triangles:>10}  primary hits of {pixels} pixels: {different} differ, {open} within rounding of an edge"
            );
        }
        let columns = ["scene", "triangles", "pixels", "different", "open"];
        exactness::write_csv(&arguments.out, "primary.csv", &columns, &records, arguments.seed, &provenance)?;
        right &= records.iter().all(|record| record.2.different == 0);
    }
    if arguments.certificates > 0 {
        let bar = bar("certificates", arguments.certificates);
        let outcome = certificates::attack(arguments.certificates, arguments.seed, |cases| bar.inc(cases))?;
        bar.finish_and_clear();
        program::print(&(account(&outcome) + "\n")).map_err(Error::msg)?;
        let (columns, rows) = (&Outcome::COLUMNS, &[outcome]);
        exactness::write_csv(&arguments.out, "certificates.csv", columns, rows, arguments.seed, &provenance)?;
        if outcome.cases < arguments.certificates {
            say(&format!("error: beams certify too little for {} cases", arguments.certificates));
        }
        right &= outcome.different == 0 && outcome.cases >= arguments.certificates;
    }
    if !right {
        say("error: not exact");
    }
    Ok(right)
}

/// Returns the scenes to compare.
fn names(arguments: &Arguments) -> Vec<String> {
    if arguments.scene.is_empty() { SCENES.map(str::to_string).to_vec() } else { arguments.scene.clone() }
}

/// Compares primary hits in each scene with brute force.
fn primary_hits(arguments: &Arguments) -> Result<Vec<(String, usize, PrimaryAgreement)>> {
    let side = u32::from(arguments.primary);
    let one = |name: String| {
        let scene = halflight_scene::resolve(&name)?.scene;
        let seen = seen(&PreparedScene::new(scene.clone())?, [side, side]);
        Ok((name, scene.mesh.triangle_count(), primary::check(&scene, &seen)))
    };
    names(arguments).into_iter().map(one).collect()
}

fn scenes(arguments: &Arguments) -> Result<Vec<Record>> {
    let settings =
        Settings { pairs: arguments.pairs, brute_force: arguments.brute_force, seed: arguments.seed };
    let mut records = Vec::new();
    for name in &names(arguments) {
        let scene = halflight_scene::resolve(name)?.scene;
        let bvh = Arc::new(Bvh::build(&scene.mesh)?);
        let mut backends = exactness::backends(&bvh)?;
        let bar = bar(name, (backends.len() as u64 - 1) * settings.pairs + settings.brute_force);
        let agreements = exactness::check(&scene, &bvh, &mut backends, &settings, |pairs| bar.inc(pairs))?;
        bar.finish_and_clear();
        records.extend(agreements.into_iter().map(|agreement| Record {
            scene: name.clone(),
            triangles: scene.mesh.triangle_count(),
            backend: agreement.name,
            pairs: agreement.pairs,
            different: agreement.different,
        }));
    }
    Ok(records)
}

/// Returns a progress bar on standard error, hidden where that is no terminal.
fn bar(what: &str, length: u64) -> ProgressBar {
    let bar = ProgressBar::new(length).with_message(what.to_string());
    let style = ProgressStyle::with_template("{msg:14} {bar:30} {human_pos}/{human_len}, {elapsed}");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar
}

/// Returns the outcome of attacks in words.
fn account(outcome: &Outcome) -> String {
    let Outcome { groups, certified, lit, umbra, cases, pairs, different, broken } = *outcome;
    let [groups, certified, lit, umbra, cases, pairs] =
        [groups, certified, lit, umbra, cases, pairs].map(|number| HumanCount(number).to_string());
    let broken = broken.map_or_else(String::new, |index| format!(", first in attack {index}"));
    format!(
        "certificates: {groups} groups attacked, {certified} certified: {lit} receivers lit, {umbra} in umbra, {cases} \
         cases of a receiver and a triangle; of {pairs} pairs of a receiver and a light sample {different} differ from \
         brute force{broken}"
    )
}
