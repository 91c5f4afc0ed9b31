//! Renders, times and measures the rows of an experiment.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::Vec3;
use halflight_core::gbuffer::GBuffer;
use halflight_core::scene::Scene;
use halflight_core::stats::FrameStats;
use halflight_cpu::config::{RefinerConfig, VisibilityConfig};
use halflight_cpu::gbuffer;
use halflight_metrics::{Comparison, Image, compare, squared_error_picture, write_png};
use rayon::prelude::*;

use super::device::{Device, Machine};
use super::experiment::Experiment;
use super::flicker::FrameError;
use super::loaded::Loaded;
use super::plan::{self, Row, Setting};
use super::progress::Progress;
use super::provenance::Provenance;
use super::record::{Finished, Measured, PaperError};
use super::state::{Header, State};
use super::{AblateError, error, flicker, timing};
use crate::reference::{Reference, ReferenceConfig, reference};
use crate::unlit::unlit;
use crate::voxel_errors::{Failures, failures};
use halflight_image::memory;
use halflight_image::picture;

/// Pipelines are held together, and so timed in turn, up to this many bytes, or half of what can be had.
const GROUP_BYTES: u64 = 3 << 30;

/// Where an experiment's files go.
#[derive(Clone, Debug)]
pub struct Places {
    /// Folder of the experiment's own files.
    pub out: PathBuf,
    /// Folder of references, which experiments share.
    pub references: PathBuf,
}

/// All rows of an experiment.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The settings.
    pub settings: Vec<Setting>,
    /// Rows in the order of the plan, setting by setting.
    pub rows: Vec<Finished>,
    /// Who made them. All rows have the same.
    pub provenance: Provenance,
}

/// Runs what is left to run of an experiment. `each` is called whenever a setting is complete, with all rows so far.
///
/// # Errors
/// A scene cannot be loaded, a row not be rendered, a file not be written.
pub fn run(
    experiment: &Experiment,
    places: &Places,
    device: &Device,
    provenance: &Provenance,
    mut each: impl FnMut(&Outcome) -> Result<(), AblateError>,
) -> Result<Outcome, AblateError> {
    let (settings, rows) = plan::plan(experiment)?;
    if matches!(device, Device::Cpu) {
        for setting in &settings {
            check_memory(setting, rows.iter())?;
        }
    }
    std::fs::create_dir_all(&places.out).map_err(error::at(&places.out))?;
    let mut state = State::open(&places.out.join("state.jsonl"), &Header::new(experiment, provenance)?)?;
    let here = |setting: &Setting| -> Vec<Row> {
        let scene = &experiment.scenes[setting.scene];
        rows.iter().filter(|row| row.is_in(scene)).map(|row| row.sized(setting.size)).collect()
    };
    let progress = Progress::new(settings.iter().map(|setting| here(setting).len() as u64).sum(), 0);
    if let Some(aside) = state.set_aside() {
        progress.say(&format!(
            "{} lines of another version of the experiment or program, or that cannot be read, are set aside in {}",
            aside.lines,
            aside.copy.display()
        ));
    }
    let mut loaded: Option<(usize, Loaded)> = None;
    for setting in &settings {
        let mine = here(setting);
        let folder = places.out.join("pictures").join(&setting.slug);
        let whole = |row: &&Row| {
            let finished = state.row(&setting.slug, &row.slug());
            finished.is_some_and(|row| {
                pictures(row, experiment).iter().all(|(_, file)| folder.join(file).is_file())
            })
        };
        let left: Vec<&Row> = mine.iter().filter(|row| !whole(row)).collect();
        progress.advance((mine.len() - left.len()) as u64);
        if left.is_empty() {
            continue;
        }
        std::fs::create_dir_all(&folder).map_err(error::at(&folder))?;
        let scene = match loaded.take() {
            Some((scene, loaded)) if scene == setting.scene => loaded,
            _ => {
                progress.now(format!("{}: loading", setting.label));
                Loaded::new(&experiment.scenes[setting.scene], &progress)?
            }
        };
        let truth = Truth::new(experiment, places, setting, &scene, &progress)?;
        truth.write_picture(&folder.join("reference.png"), &truth.reference.irradiance)?;
        let frames = match &experiment.flicker {
            Some(choice) => {
                flicker::measure(experiment, choice, &places.references, setting, &scene, &left, &progress)?
            }
            None => vec![Vec::new(); left.len()],
        };
        let left: Vec<(&Row, Vec<FrameError>)> = left.into_iter().zip(frames).collect();
        let bench =
            Bench { experiment, device, provenance, setting, scene: &scene, truth: &truth, folder: &folder };
        bench.run(&left, &mut state, &progress)?;
        loaded = Some((setting.scene, scene));
        each(&outcome(&settings, &rows, &state, provenance))?;
    }
    progress.finish();
    let outcome = outcome(&settings, &rows, &state, provenance);
    each(&outcome)?;
    Ok(outcome)
}

/// Refuses sizes whose images do not fit into memory, before anything is rendered.
fn check_memory<'a>(setting: &Setting, rows: impl Iterator<Item = &'a Row>) -> Result<(), AblateError> {
    let most = rows.map(|row| row.sized(setting.size).config.bytes_needed()).max().unwrap_or(0);
    let [width, height] = setting.size;
    Ok(memory::check(format!("{}: an image of {width}x{height} pixels", setting.label), most)?)
}

fn outcome(settings: &[Setting], rows: &[Row], state: &State, provenance: &Provenance) -> Outcome {
    let pairs = settings.iter().flat_map(|setting| rows.iter().map(move |row| (setting, row)));
    let finished = pairs.filter_map(|(setting, row)| state.row(&setting.slug, &row.slug()).cloned());
    Outcome { settings: settings.to_vec(), rows: finished.collect(), provenance: provenance.clone() }
}

/// A picture of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum PictureKind {
    Image,
    Fragments,
    Error,
    SquaredError,
    Failures,
}

impl PictureKind {
    const ALL: [Self; 5] = [Self::Image, Self::Fragments, Self::Error, Self::SquaredError, Self::Failures];

    /// What the report calls it.
    fn name(self) -> &'static str {
        match self {
            Self::Image => "picture",
            Self::Fragments => "fragments",
            Self::Error => "error",
            Self::SquaredError => "squared error",
            Self::Failures => "failures",
        }
    }

    fn file(self, row: &Finished) -> String {
        match self {
            Self::Image => format!("{}.png", row.row),
            Self::Fragments => format!("{}-fragments.png", row.fragments),
            Self::Error => format!("{}-error.png", row.row),
            Self::SquaredError => format!("{}-squared.png", row.row),
            Self::Failures => format!("{}-failures.png", row.row),
        }
    }

    fn is_made(self, row: &Finished, experiment: &Experiment) -> bool {
        match self {
            Self::SquaredError => experiment.squared_error_factor.is_some(),
            Self::Failures => row.record.off_share.is_some(),
            _ => true,
        }
    }
}

/// Names and files of a row's pictures in its setting's folder: picture, fragment map, error map, squared errors if asked
/// for, and where voxel marching fails.
pub fn pictures(row: &Finished, experiment: &Experiment) -> Vec<(&'static str, String)> {
    let made = PictureKind::ALL.iter().filter(|kind| kind.is_made(row, experiment));
    made.map(|kind| (kind.name(), kind.file(row))).collect()
}

/// What rows of a setting are measured against.
struct Truth {
    scene: Arc<Scene>,
    reference: Reference,
    /// An image as papers take for a reference.
    paper: Option<Vec<Vec3>>,
    gbuffer: GBuffer,
    /// Pixels that see geometry.
    receivers: Vec<bool>,
}

impl Truth {
    fn new(
        experiment: &Experiment,
        places: &Places,
        setting: &Setting,
        loaded: &Loaded,
        progress: &Progress,
    ) -> Result<Self, AblateError> {
        let scene = loaded.lit(setting.light_scale);
        let config = experiment.reference_of(setting);
        let ReferenceConfig { width, height, seed, .. } = config;
        let mut said = |done: u32, all: u32| {
            progress.now(format!("{}: reference, {done} of {all} samples a pixel", setting.label));
        };
        let reference = reference(&scene, &loaded.bvh, &config, Some(&places.references), &mut said)?;
        let paper = match experiment.paper.as_ref().and_then(|paper| paper.reference_samples) {
            Some(count) => {
                let row = Row::monte_carlo(width, height, count, seed);
                let builder = row.config.builder(Arc::clone(&scene), Arc::clone(&loaded.bvh));
                let mut pipeline = builder.build().map_err(|source| fault(&row, source))?;
                Some(pipeline.render().map_err(|source| fault(&row, source))?.irradiance.clone())
            }
            None => None,
        };
        let mut gbuffer = GBuffer::default();
        gbuffer::trace(&loaded.bvh, &scene, width, height, &mut gbuffer);
        if let Some(reason) = unlit(&scene, &gbuffer, &reference.irradiance) {
            return Err(AblateError::Unlit { setting: setting.label.clone(), reason });
        }
        let receivers = (0..gbuffer.pixels()).map(|pixel| gbuffer.is_receiver(pixel)).collect();
        Ok(Self { scene, reference, paper, gbuffer, receivers })
    }

    fn image<'a>(&'a self, pixels: &'a [Vec3]) -> Result<Image<'a>, AblateError> {
        let (width, height) = (self.reference.width, self.reference.height);
        Ok(Image::new(width, height, pixels)?.with_mask(&self.receivers)?)
    }

    fn write_picture(&self, path: &Path, irradiance: &[Vec3]) -> Result<(), AblateError> {
        let picture = picture::image(irradiance, &self.gbuffer.albedo, picture::EXPOSURE);
        Ok(write_png(path, self.gbuffer.width, self.gbuffer.height, &picture)?)
    }

    /// Errors against a reference, and its SSE after division by the reference's peak.
    fn errors(
        &self,
        row: &Row,
        irradiance: &[Vec3],
        reference: &[Vec3],
    ) -> Result<(Comparison, f64), AblateError> {
        let errors = compare(self.image(irradiance)?, self.image(reference)?)
            .map_err(|source| AblateError::Compare { row: row.label(), source })?;
        let lit = reference.iter().zip(&self.receivers).filter(|(_, receives)| **receives);
        let peak = f64::from(lit.fold(0.0f32, |peak, (value, _)| peak.max(value.abs().max_element())));
        Ok((errors, errors.sse / (peak * peak)))
    }
}

/// A pipeline on the bench.
struct Running<'a> {
    row: &'a Row,
    machine: Machine,
    times: Vec<FrameStats>,
    frames: &'a [FrameError],
}

/// Rows of one setting, side by side.
struct Bench<'a> {
    experiment: &'a Experiment,
    device: &'a Device,
    provenance: &'a Provenance,
    setting: &'a Setting,
    scene: &'a Loaded,
    truth: &'a Truth,
    folder: &'a Path,
}

impl Bench<'_> {
    fn run(
        &self,
        rows: &[(&Row, Vec<FrameError>)],
        state: &mut State,
        progress: &Progress,
    ) -> Result<(), AblateError> {
        let mut left = rows.iter();
        loop {
            let most = memory::available().map_or(GROUP_BYTES, |bytes| GROUP_BYTES.min(bytes / 2));
            let mut group: Vec<Running> = Vec::new();
            let mut bytes = 0;
            for (row, frames) in left.by_ref() {
                progress.now(format!("{}: warming {}", self.setting.label, row.label()));
                let Some(running) = self.warm(row, frames)? else {
                    progress.say(&format!("{}: {} has no such stages", row.label(), self.device.name()));
                    progress.advance(1);
                    continue;
                };
                bytes += running.machine.stats().peak_bytes.saturating_sub(self.scene.bvh.bytes() as u64);
                group.push(running);
                if bytes > most {
                    break;
                }
            }
            if group.is_empty() {
                return Ok(());
            }
            // Round and round: whatever slows the machine for a while slows all rows alike.
            let of = self.experiment.repetitions_of(self.setting.scene);
            for repetition in 1..=of {
                for running in &mut group {
                    progress.now(format!(
                        "{}: round {repetition} of {of}, {}",
                        self.setting.label,
                        running.row.label()
                    ));
                    let stats = running.machine.render(running.row)?;
                    running.times.push(stats);
                }
            }
            progress.now(format!("{}: measuring {} rows", self.setting.label, group.len()));
            group.iter_mut().try_for_each(|running| running.machine.fetch())?;
            let finished: Vec<Finished> =
                group.into_par_iter().map(|running| self.measure(&running)).collect::<Result<_, _>>()?;
            for row in finished {
                state.append(row)?;
                progress.advance(1);
            }
        }
    }

    /// Builds a pipeline and renders the frame that is not timed.
    fn warm<'r>(&self, row: &'r Row, frames: &'r [FrameError]) -> Result<Option<Running<'r>>, AblateError> {
        let Some(mut machine) = self.device.machine(row, &self.truth.scene, &self.scene.bvh)? else {
            return Ok(None);
        };
        machine.render(row)?;
        Ok(Some(Running { row, machine, times: Vec::new(), frames }))
    }

    fn measure(&self, running: &Running) -> Result<Finished, AblateError> {
        let (row, irradiance, stats) = (running.row, running.machine.irradiance(), running.machine.stats());
        let (errors, normalised_sse) =
            self.truth.errors(row, irradiance, &self.truth.reference.irradiance)?;
        let paper = match &self.truth.paper {
            Some(reference) => {
                let (errors, sse) = self.truth.errors(row, irradiance, reference)?;
                Some(PaperError { sse, nmse: errors.nmse })
            }
            None => None,
        };
        let failures = self.failures(row)?;
        let measured = Measured {
            experiment: &self.experiment.name,
            scene: &self.scene.name,
            triangles: self.scene.bvh.triangle_count(),
            setting: self.setting,
            row,
            stats,
            times: timing::medians(&running.times),
            errors,
            failures: failures.as_ref(),
            frames: running.frames,
            reference_noise: self.truth.reference.noise_nmse2,
            provenance: self.provenance,
        };
        let finished = Finished {
            setting: self.setting.slug.clone(),
            row: row.slug(),
            fragments: row.fragments_slug(),
            label: row.label(),
            normalised_sse,
            paper,
            per_level: stats.fragments.per_level,
            frames: running.frames.to_vec(),
            record: measured.record(),
        };
        self.write_pictures(running, &finished)?;
        if let Some(failures) = failures {
            let [width, height] = self.setting.size;
            let path = self.folder.join(PictureKind::Failures.file(&finished));
            write_png(&path, width, height, &failures.image)?;
        }
        Ok(finished)
    }

    /// Where voxel marching fails, for rows that ask it about every pixel.
    fn failures(&self, row: &Row) -> Result<Option<Failures>, AblateError> {
        let (RefinerConfig::Full, VisibilityConfig::Voxel(voxel)) =
            (row.config.refiner, row.config.visibility)
        else {
            return Ok(None);
        };
        let (scene, gbuffer) = (&self.truth.scene, &self.truth.gbuffer);
        let found = failures(scene, &self.scene.bvh, gbuffer, voxel, row.config.sampling, row.config.seed);
        found.map(Some).map_err(|source| fault(row, source))
    }

    fn write_pictures(&self, running: &Running, finished: &Finished) -> Result<(), AblateError> {
        let irradiance = running.machine.irradiance();
        let (image, reference) =
            (self.truth.image(irradiance)?, self.truth.image(&self.truth.reference.irradiance)?);
        let fault = |source| AblateError::Compare { row: finished.label.clone(), source };
        let (width, height) = (image.width(), image.height());
        let [picture, fragments, error, squared, _] =
            PictureKind::ALL.map(|kind| self.folder.join(kind.file(finished)));
        self.truth.write_picture(&picture, irradiance)?;
        if !fragments.is_file() {
            let map = running.machine.fragment_map(&self.truth.gbuffer);
            write_png(&fragments, width, height, &map)?;
        }
        let map = picture::error(image, reference, self.experiment.error_scale).map_err(fault)?;
        write_png(&error, width, height, &map)?;
        if let Some(factor) = self.experiment.squared_error_factor {
            let map = squared_error_picture(image, reference, factor).map_err(fault)?;
            write_png(&squared, width, height, &map)?;
        }
        Ok(())
    }
}

fn fault(row: &Row, source: halflight_cpu::pipeline::PipelineError) -> AblateError {
    AblateError::Pipeline { row: row.label(), source }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TINY: &str = r#"
        title = "tiny"
        description = "two rows, two sizes of light"
        size = [48, 36]
        repetitions = 2
        light_scales = [1, 2]
        squared_error_factor = 9
        [reference]
        samples = 512
        seed = 9
        [[scene]]
        name = "contact"
        [[grid]]
        refiners = [{ name = "sfvt-gass" }, { name = "full" }]
        upsamplers = ["bilinear"]
        shadings = ["ratio"]
        samples = [16]
        [paper]
        source = "none"
        differs = "everything"
        reference_samples = 16
    "#;

    fn finish(places: &Places) -> Outcome {
        let experiment = Experiment::parse(TINY, "tiny.toml").unwrap();
        let provenance = Provenance {
            commit: "c".to_string(),
            machine: "m".to_string(),
            threads: 1,
            device: "cpu".to_string(),
            program: 1,
        };
        run(&experiment, places, &Device::Cpu, &provenance, |_| Ok(())).unwrap()
    }

    #[test]
    fn a_run_measures_every_row_and_goes_on_where_it_was() {
        let root = std::env::temp_dir().join(format!("halflight-run-{}", std::process::id()));
        let places = Places { out: root.join("out"), references: root.join("references") };
        let whole = finish(&places);
        assert_eq!(whole.rows.len(), 4);
        for row in &whole.rows {
            let record = &row.record;
            assert!(record.total_ms > 0.0 && record.rays > 0 && record.fragments > 0);
            assert!(record.nmse2 > 0.0 && record.nmse2 < 0.05, "{}: {}", row.label, record.nmse2);
            // Its reference has as few samples as the row itself: farther from it than from the converged one.
            assert!(row.paper.unwrap().nmse > record.nmse);
        }
        // Two twice as long edges make four times the light, but no other row.
        assert!(whole.rows[2].record.sse > whole.rows[0].record.sse);

        // As if it had been stopped after the first row.
        let state = places.out.join("state.jsonl");
        let text = std::fs::read_to_string(&state).unwrap();
        let kept: String = text.split_inclusive('\n').take(2).collect();
        std::fs::write(&state, kept).unwrap();
        let resumed = finish(&places);
        assert_eq!(resumed.rows.len(), 4);
        assert_eq!(resumed.rows[0], whole.rows[0]);
        for (again, before) in resumed.rows.iter().zip(&whole.rows) {
            assert_eq!((again.record.sse, again.record.rays), (before.record.sse, before.record.rays));
        }
        std::fs::remove_dir_all(&root).unwrap();
    }
}
