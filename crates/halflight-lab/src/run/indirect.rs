//! Indirect light of a setting, timed and measured against one diffuse reflection.

use std::f32::consts::PI;
use std::path::Path;

use anyhow::{Context as _, Result, anyhow, bail};
use glam::Vec3;
use halflight_core::stats::FrameStats;
use halflight_cpu::pipeline::Pipeline;
use halflight_image::picture;
use halflight_metrics::{Image, luminance, nmse2, tone_map, write_png};

use super::flicker::{self, Light};
use super::loaded::Loaded;
use super::progress::Progress;
use super::timing::median;
use crate::experiment::Experiment;
use crate::experiment::plan::{self, IndirectChoice, Row, Setting};
use crate::reference::bounce::{OneBounce, luminances, one_bounce};
use crate::reference::{receivers, seen};
use crate::results::indirect::{DARK, LEAK};
use crate::results::{IndirectRow, Means, Provenance};

/// Mean radiance of the reference in pictures of indirect light, W/m²/sr: they are all as bright as that makes them.
const BRIGHTNESS: f64 = 0.2;

/// Pipeline of a method that is timed.
struct Running<'a> {
    choice: &'a IndirectChoice,
    pipeline: Pipeline,
    /// Time to place points in the first frame.
    place_ms: f64,
    times: Vec<FrameStats>,
}

/// Renders and measures all methods in a setting, and writes their pictures.
pub(super) fn measure(
    experiment: &Experiment,
    out: &Path,
    references: &Path,
    setting: &Setting,
    loaded: &Loaded,
    provenance: &Provenance,
    progress: &Progress,
) -> Result<Vec<IndirectRow>> {
    let choices = plan::indirect(experiment).map_err(|message| anyhow!("{}: {message}", experiment.name))?;
    let choices: Vec<IndirectChoice> = choices
        .into_iter()
        .map(|choice| IndirectChoice { row: choice.row.sized(setting.size), ..choice })
        .collect();
    let folder = out.join("pictures").join(&setting.slug);
    fs_err::create_dir_all(&folder)?;
    let scene = loaded.lit(setting.light_scale)?;
    let mut said = |done: u32, all: u32| {
        progress.now(format!("{}: indirect light, {done} of {all} rays a pixel", setting.label));
    };
    let config = experiment.indirect_reference_of(setting);
    let truth = one_bounce(&scene, &config, Some(references), &mut said)?;
    let mask = receivers(&seen(&scene, setting.size));
    let mean = Judged::new(&truth, &mask).mean;
    if mean == 0.0 {
        bail!(
            "{}: no surface reflects light towards a visible one; errors relative to that are undefined",
            setting.label
        );
    }
    let exposure = (BRIGHTNESS * f64::from(PI) / mean) as f32;
    let bright =
        |irradiance: &[Vec3]| picture::image(irradiance, &vec![Vec3::ONE; irradiance.len()], exposure);
    let [width, height] = setting.size;
    write_png(&folder.join("indirect-reference.png"), width, height, &bright(&truth.irradiance))?;

    let mut running = Vec::new();
    for choice in &choices {
        progress.now(format!("{}: warming {}", setting.label, choice.label));
        let mut pipeline = choice.row.builder(&scene).build().with_context(|| choice.label.clone())?;
        let place_ms = pipeline.render().with_context(|| choice.label.clone())?.stats.indirect.place_ms;
        running.push(Running { choice, pipeline, place_ms, times: Vec::new() });
    }
    // Round and round, as for other rows.
    let of = experiment.repetitions_of(setting.scene);
    for repetition in 1..=of {
        for Running { choice, pipeline, times, .. } in &mut running {
            progress.now(format!("{}: round {repetition} of {of}, {}", setting.label, choice.label));
            pipeline.set_frame_index(0);
            times.push(pipeline.render().with_context(|| choice.label.clone())?.stats.clone());
        }
    }
    let pipelines: Vec<&Row> = choices.iter().map(|choice| &choice.row).collect();
    let frames =
        flicker::measure(Light::Indirect, experiment, references, setting, loaded, &pipelines, progress)?;
    let mut rows = Vec::new();
    for (running, frames) in running.iter().zip(frames) {
        let image = running.pipeline.image();
        let row = IndirectRow {
            setting: setting.slug.clone(),
            slug: running.choice.slug(),
            experiment: experiment.name.clone(),
            scene: loaded.name.clone(),
            size: setting.size,
            flicker: Means::of(&frames).map(|means| [means.mean, means.p99, means.noise]),
            threads: provenance.threads,
            commit: provenance.commit.clone(),
            machine: provenance.machine.clone(),
            ..measured(running, &truth, &mask)?
        };
        let [indirect, error, whole] = row.pictures().map(|file| folder.join(file));
        write_png(&indirect, width, height, &bright(&image.indirect))?;
        let view = |pixels| -> Result<Image<'_>> { Ok(Image::new(width, height, pixels)?.with_mask(&mask)?) };
        let (found, expected) = (view(&image.indirect)?, view(&truth.irradiance)?);
        write_png(&error, width, height, &picture::error(found, expected, experiment.error_scale)?)?;
        write_png(&whole, width, height, &tone_map(&image.radiance, picture::EXPOSURE))?;
        rows.push(row);
    }
    Ok(rows)
}

/// Reference of the luminance at the pixels that take part.
struct Judged<'a> {
    truth: &'a OneBounce,
    mask: &'a [bool],
    receivers: u64,
    /// Mean over these pixels.
    mean: f64,
}

impl<'a> Judged<'a> {
    fn new(truth: &'a OneBounce, mask: &'a [bool]) -> Self {
        let receivers = mask.iter().filter(|taken| **taken).count() as u64;
        let mut judged = Self { truth, mask, receivers, mean: 0.0 };
        judged.mean = judged.mean_of(&truth.irradiance);
        judged
    }

    fn mean_of(&self, pixels: &[Vec3]) -> f64 {
        let taken = pixels.iter().zip(self.mask).filter(|(_, taken)| **taken);
        taken.map(|(&pixel, _)| luminance(pixel.into())).sum::<f64>() / self.receivers.max(1) as f64
    }

    /// Returns the number of leaks.
    fn leaks(&self, pixels: &[Vec3]) -> u64 {
        let leaks = |pair: &((&Vec3, &Vec3), &bool)| {
            let ((found, expected), taken) = *pair;
            let [found, expected] = [found, expected].map(|pixel| luminance((*pixel).into()));
            *taken && expected < DARK * self.mean && found > LEAK * self.mean
        };
        pixels.iter().zip(&self.truth.irradiance).zip(self.mask).filter(leaks).count() as u64
    }
}

/// Returns counts, times and errors of a method.
fn measured(running: &Running, truth: &OneBounce, mask: &[bool]) -> Result<IndirectRow> {
    let Running { choice, pipeline, place_ms, times } = running;
    let image = pipeline.image();
    let counts = &image.stats.indirect;
    let judged = Judged::new(truth, mask);
    let of = |time: fn(&FrameStats) -> f64| median(times.iter().map(time));
    let grey = [&image.indirect, &truth.irradiance].map(|pixels| luminances(pixels));
    let view =
        |pixels| -> Result<Image<'_>> { Ok(Image::new(truth.width, truth.height, pixels)?.with_mask(mask)?) };
    Ok(IndirectRow {
        label: choice.label.clone(),
        direct: choice.row.label(),
        points: counts.points,
        lit: counts.lit,
        records: counts.records,
        light_rays: counts.light_rays,
        gather_rays: counts.gather_rays,
        place_ms: *place_ms,
        light_ms: of(|frame| frame.indirect.light_ms),
        transport_ms: of(|frame| frame.indirect.transport_ms),
        lookup_ms: of(|frame| frame.indirect.lookup_ms),
        indirect_ms: of(|frame| frame.stages_ms.indirect),
        direct_ms: of(|frame| frame.total_ms - frame.stages_ms.indirect),
        nmse2: nmse2(view(&grey[0])?, view(&grey[1])?).with_context(|| choice.label.clone())?,
        reference_noise: truth.noise_luminance,
        bias: judged.mean_of(&image.indirect) / judged.mean - 1.0,
        leaks: judged.leaks(&image.indirect),
        receivers: judged.receivers,
        ..IndirectRow::default()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const EXPERIMENT: &str = r#"
        title = "t"
        description = "d"
        size = [40, 30]
        repetitions = 1
        reference = { samples = 512, rays = 64, seed = 7 }
        flicker = { frames = 2, step = 0.5 }
        scene = [{ name = "nave" }]
        indirect = [{ name = "lpv" }, { name = "gather", points = [200, 4000] }]
        [[grid]]
        refiners = [{ name = "per-pixel" }]
        upsamplers = ["bilinear"]
        shadings = ["ratio"]
        samples = [4]
    "#;

    #[test]
    fn methods_are_measured_against_one_reflection() {
        let folder = tempfile::tempdir().unwrap();
        let (out, references) = (folder.path().join("out"), folder.path().join("references"));
        let none = Provenance::default();
        let experiment = Experiment::parse(EXPERIMENT, "tiny.toml").unwrap();
        let (settings, progress) = (plan::settings(&experiment), Progress::hidden());
        let loaded = Loaded::new(&experiment.scenes[0], &progress).unwrap();
        let rows = measure(&experiment, &out, &references, &settings[0], &loaded, &none, &progress).unwrap();
        let [lpv, few, many] = &rows[..] else { panic!("{} rows", rows.len()) };
        for row in &rows {
            assert!(row.points > 0 && row.lit > 0 && row.indirect_ms > 0.0 && row.direct_ms > 0.0, "{row:?}");
            assert!(row.nmse2 > 0.0 && row.reference_noise > 0.0 && row.flicker.is_some(), "{row:?}");
            assert!(row.pictures().iter().all(|file| out.join("pictures/nave").join(file).is_file()));
        }
        assert!(lpv.gather_rays == 0 && few.gather_rays > 0 && few.records > 0 && many.points > few.points);
        // Points gathered with exact visibility are nearer to the reference than a coarse grid, and so are more of them.
        assert!(
            many.nmse2 < lpv.nmse2 && many.nmse2 < few.nmse2,
            "{} {} {}",
            lpv.nmse2,
            few.nmse2,
            many.nmse2
        );
    }

    #[test]
    fn leaks_are_light_where_there_is_none() {
        let grey = |values: [f32; 4]| values.map(Vec3::splat).to_vec();
        let truth = OneBounce { irradiance: grey([1.0, 0.0, 0.005, 3.0]), ..OneBounce::default() };
        let judged = Judged::new(&truth, &[true, true, true, false]);
        // The mean is 0.335: below 0.00335 is dark, and above 0.01675 a leak.
        assert!((judged.mean - 0.335).abs() < 1e-6);
        assert_eq!(judged.leaks(&grey([0.0, 0.02, 1.0, 1.0])), 1);
        assert_eq!(judged.leaks(&grey([0.0, 0.01, 1.0, 1.0])), 0);
    }
}
