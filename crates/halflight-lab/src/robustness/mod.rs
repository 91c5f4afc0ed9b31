//! Robustness suite: every combination of the stages in a list of awkward cases.
//!
//! A [`Case`] is a small scene with one thing in it that methods stumble over. Every
//! [`Method`] renders it; [`judge`] says whether the picture passes, is degraded (by how much) or fails,
//! against a converged reference and against what can be asked of the method. Where it does not pass, the method is
//! looked for that passes with the fewest stages switched.

pub mod cases;
pub mod glossy;
pub mod indirect;
pub mod judge;
mod measure;
pub mod methods;
pub mod output;
mod page;
mod reasons;
mod scenes;

use std::collections::HashMap;
use std::path::Path;

use anyhow::{Result, bail};
use glam::Vec3;
use halflight_cpu::config::{Named, VisibilityConfig};
use itertools::Itertools as _;
use rayon::prelude::*;

use crate::run::Progress;
use cases::{Case, EASY};
use judge::{Fault, Figure, Verdict, Yardsticks};
use measure::Ready;
use methods::{Method, Switch};

/// Name of the suite on the command line.
pub const NAME: &str = "robustness";

/// Name of the suite in version 0.1, which is still read.
pub const OLD_NAME: &str = "stability";

/// Title of the suite.
pub const TITLE: &str = "Where methods fail: every combination of stages in awkward cases";

/// Light samples a pixel of the references: their noise is then a tenth of what counts as no error.
const REFERENCE_SAMPLES: u32 = 1024;

/// Cases and methods of a run.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Cases; the easy one first, since all others are held against it.
    pub cases: Vec<Case>,
    /// Methods.
    pub methods: Vec<Method>,
    /// Methods that also render the large cases.
    pub for_large: Vec<Method>,
    /// Light samples a pixel of the references.
    pub reference_samples: u32,
}

impl Plan {
    /// Returns everything, or one case and the easy one. The quick version switches one stage at a time and leaves the large
    /// cases out.
    ///
    /// # Errors
    /// No case has the name.
    pub fn new(case: Option<&str>, quick: bool) -> Result<Self> {
        let all = cases::all();
        if let Some(name) = case
            && !all.iter().any(|case| case.name == name)
        {
            bail!("there is no case `{name}`; there are {}", all.iter().map(|case| case.name).join(", "));
        }
        let wanted =
            |each: &Case| each.name == EASY || case.map_or(!(quick && each.large), |name| each.name == name);
        let few = methods::few();
        Ok(Self {
            cases: all.into_iter().filter(wanted).collect(),
            methods: if quick { few.clone() } else { methods::all() },
            for_large: few,
            reference_samples: REFERENCE_SAMPLES,
        })
    }

    /// Returns the number of pictures.
    pub fn pictures(&self) -> u64 {
        self.cases.iter().map(|case| self.methods_of(case).len() as u64).sum()
    }

    /// Returns the methods that render a case: those of its size whose backend answers for its lights.
    fn methods_of(&self, case: &Case) -> Vec<Method> {
        let methods = if case.large { &self.for_large } else { &self.methods };
        methods.iter().filter(|method| method.answers(&case.scenes)).copied().collect()
    }
}

/// Method in a case.
#[derive(Clone, Debug)]
pub struct Cell {
    /// Method.
    pub method: Method,
    /// Distance from the reference; `None` where there is no picture.
    pub figure: Option<Figure>,
    /// Verdict on the picture.
    pub verdict: Verdict,
    /// Fewest switches to a method that passes; none where the method passes itself, or no method does.
    pub mends: Vec<Switch>,
    /// Reason why the method does not pass, if that is known.
    pub why: String,
    /// Path of the picture in the folder of the output; `None` where the method passes or there is no picture.
    pub picture: Option<String>,
}

/// All methods in a case.
#[derive(Clone, Debug)]
pub struct Row {
    /// Name of the case.
    pub case: &'static str,
    /// Difficulty of the case.
    pub title: &'static str,
    /// NMSE₂ of the picture without any shadow.
    pub unshadowed: f64,
    /// Cells in the order of the methods.
    pub cells: Vec<Cell>,
}

/// Runs a plan, and writes the pictures of what does not pass, and of the easy case, to `out`.
///
/// # Errors
/// A reference cannot be rendered, a picture not be written. Methods that break do not end the run.
pub fn run(plan: &Plan, out: &Path, progress: &Progress) -> Result<Vec<Row>> {
    fs_err::create_dir_all(out)?;
    let mut easy = Vec::new();
    let mut rows = Vec::new();
    for case in &plan.cases {
        progress.now(format!("{}: reference", case.name));
        let ready = Ready::new(case, plan.reference_samples)?;
        let rendered = render(case, &ready, &plan.methods_of(case), progress);
        if case.name == EASY {
            easy = rendered.iter().map(|one| (one.method, one.figure.clone())).collect();
        }
        let verdicts = verdicts(&rendered, &ready, &easy);
        let passing = rendered.iter().zip(&verdicts).filter(|(_, verdict)| **verdict == Verdict::Pass);
        let passing: Vec<(Method, f64)> =
            passing.filter_map(|(one, _)| Some((one.method, one.figure.as_ref().ok()?.nmse2))).collect();
        let cells = rendered.par_iter().zip(&verdicts).map(|(one, verdict)| {
            let passes = *verdict == Verdict::Pass;
            let shown = (!passes || case.name == EASY) && !one.pictures.is_empty();
            let picture = || output::picture(out, case, &one.method, &one.pictures, &ready);
            let mends = if passes { Vec::new() } else { mends(&one.method, &passing) };
            Ok(Cell {
                method: one.method,
                figure: one.figure.as_ref().ok().copied(),
                verdict: verdict.clone(),
                why: if passes { String::new() } else { why(case, verdict, &mends) },
                mends,
                picture: shown.then(picture).transpose()?,
            })
        });
        let cells = cells.collect::<Result<_>>()?;
        let unshadowed = ready.error_without_shadow();
        rows.push(Row { case: case.name, title: case.title, unshadowed, cells });
    }
    progress.finish();
    Ok(rows)
}

/// Pictures of a method in a case.
struct Rendered {
    method: Method,
    pictures: Vec<Vec<Vec3>>,
    figure: Result<Figure, Fault>,
}

fn render(case: &Case, ready: &Ready, methods: &[Method], progress: &Progress) -> Vec<Rendered> {
    let one = |method: &Method| {
        progress.now(format!("{}: {}", case.name, method.label()));
        let found = ready.render(method);
        progress.advance(1);
        let figure = found.as_ref().map_err(Clone::clone).and_then(|pictures| ready.figure(pictures));
        Rendered { method: *method, pictures: found.unwrap_or_default(), figure }
    };
    // Most pictures are too small to keep a machine busy; the buffers of many large ones would not fit.
    if case.large { methods.iter().map(one).collect() } else { methods.par_iter().map(one).collect() }
}

/// Returns a verdict on every method.
fn verdicts(rendered: &[Rendered], ready: &Ready, easy: &[(Method, Result<Figure, Fault>)]) -> Vec<Verdict> {
    let mut every_pixel = HashMap::new();
    for Rendered { method, .. } in rendered {
        let key = (method.shading, method.sampling());
        every_pixel.entry(key).or_insert_with(|| ready.error_of_every_pixel(method));
    }
    let unshadowed = ready.error_without_shadow();
    let verdict = |one: &Rendered| {
        let figure = match &one.figure {
            Ok(figure) => figure,
            Err(fault) => return Verdict::Broken(fault.clone()),
        };
        let own = easy.iter().find(|(method, _)| *method == one.method);
        let own = own.and_then(|(_, figure)| figure.as_ref().ok()).map_or(0.0, |figure| figure.nmse2);
        let every_pixel = every_pixel.get(&(one.method.shading, one.method.sampling()));
        let yardsticks =
            Yardsticks { easy: own, every_pixel: every_pixel.copied().unwrap_or_default(), unshadowed };
        judge::judge(figure, &yardsticks)
    };
    rendered.iter().map(verdict).collect()
}

/// Returns the fault of the picture in itself, and why the choices fail that are switched to mend it.
fn why(case: &Case, verdict: &Verdict, mends: &[Switch]) -> String {
    let fault = if let Verdict::Broken(fault) = verdict { fault.to_string() } else { String::new() };
    let known = mends.iter().map(|switch| reasons::why(case.name, switch.stage, &switch.from));
    let all = mends.is_empty().then(|| reasons::why_all(case.name));
    [fault.as_str()].into_iter().chain(known).chain(all).filter(|why| !why.is_empty()).join("; ")
}

/// Returns the fewest switches from a method to one of those that pass, given with their errors. Of those of as many switches,
/// tracing every pixel comes last, backends in the order of their names, and then the most accurate first.
fn mends(method: &Method, passing: &[(Method, f64)]) -> Vec<Switch> {
    let ways = passing.iter().map(|(other, nmse2)| (method.switches(other), other.is_every_pixel(), *nmse2));
    let order = |(switches, every_pixel, nmse2): &(Vec<Switch>, bool, f64)| {
        let backend = switches.iter().find(|switch| switch.stage == "visibility");
        let backend = backend.map(|to| VisibilityConfig::NAMES.iter().position(|name| *name == to.to));
        (switches.len(), *every_pixel, backend, nmse2.to_bits())
    };
    ways.min_by_key(order).map_or(Vec::new(), |(switches, ..)| switches)
}

/// Refuses cells without a sound picture: NaN, infinite or negative values, panics, refusals.
///
/// # Errors
/// Rows have faults; the first is named.
pub fn check(rows: &[Row]) -> Result<()> {
    let cells = rows.iter().flat_map(|row| row.cells.iter().map(move |cell| (row, cell)));
    let broken: Vec<String> = cells
        .filter_map(|(row, cell)| match &cell.verdict {
            Verdict::Broken(fault) => Some(format!("{}, {}: {fault}", row.case, cell.method.label())),
            _ => None,
        })
        .collect();
    if let Some(first) = broken.first() {
        let count = broken.len();
        bail!("{count} pictures are not finite, negative, or not there at all; the first: {first}");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use halflight_cpu::config::UpsamplerConfig;
    use halflight_cpu::irradiance::Shading;

    use super::*;

    #[test]
    fn voxels_fail_where_the_occluder_is_out_of_view_and_rays_mend_it() {
        let mut plan = Plan::new(Some("out-of-view"), true).unwrap();
        plan.reference_samples = 512;
        let every_pixel = Method::every_pixel(Shading::Ratio);
        let voxel = VisibilityConfig::named("voxel").unwrap();
        plan.methods = vec![every_pixel, Method { visibility: voxel, ..every_pixel }];
        let out = tempfile::tempdir().unwrap();
        let rows = run(&plan, out.path(), &Progress::hidden()).unwrap();
        let [easy, hidden] = rows.as_slice() else { panic!("{} cases", rows.len()) };
        assert_eq!((easy.case, hidden.case), (EASY, "out-of-view"));
        assert_eq!(hidden.cells[0].verdict, Verdict::Pass);
        let failed = &hidden.cells[1];
        assert_eq!(
            (failed.verdict.word(), methods::set(&failed.mends)),
            ("fails", "visibility = bvh".to_string())
        );
        assert!(failed.why.contains("frustum"), "{}", failed.why);
        assert!(out.path().join(failed.picture.as_ref().unwrap()).is_file());
        check(&rows).unwrap();
    }

    #[test]
    fn an_unknown_case_is_refused() {
        let fault = Plan::new(Some("nowhere"), false).unwrap_err().to_string();
        assert!(fault.contains("`nowhere`") && fault.contains("out-of-view"), "{fault}");
    }

    #[test]
    fn mending_takes_the_fewest_switches_and_every_pixel_last() {
        let every_pixel = Method::every_pixel(Shading::Ratio);
        let refined = methods::few().into_iter().find(|method| !method.is_every_pixel()).unwrap();
        let ill = Method {
            upsampler: UpsamplerConfig::RbfFixed(Default::default()),
            shading: Shading::Ratio,
            ..refined
        };
        let well = Method { upsampler: UpsamplerConfig::Delaunay(Default::default()), ..ill };
        let better = Method { upsampler: UpsamplerConfig::RbfRobust(Default::default()), ..ill };
        let passing = [(every_pixel, 1e-6), (well, 3e-5), (better, 2e-5)];
        assert_eq!(methods::set(&mends(&ill, &passing)), "upsampler = rbf-robust");
        assert_eq!(methods::set(&mends(&ill, &passing[..2])), "upsampler = delaunay");
        assert_eq!(methods::set(&mends(&ill, &passing[..1])), "refiner = per-pixel");
        assert!(mends(&ill, &[]).is_empty());
    }

    #[test]
    fn a_picture_that_is_none_fails_the_run() {
        let cell = Cell {
            method: Method::every_pixel(Shading::Ratio),
            figure: None,
            verdict: Verdict::Broken(Fault::Panic("over".to_string())),
            mends: Vec::new(),
            why: String::new(),
            picture: None,
        };
        let rows = [Row { case: EASY, title: "", unshadowed: 0.0, cells: vec![cell] }];
        let fault = check(&rows).unwrap_err().to_string();
        assert!(fault.contains("easy, per-pixel · bvh · ratio: panic: over"), "{fault}");
        assert!(check(&[]).is_ok());
    }
}
