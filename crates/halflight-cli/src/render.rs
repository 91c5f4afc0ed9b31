//! `halflight render`.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use halflight_core::fragment::Fragments;
use halflight_core::gbuffer::GBuffer;
use halflight_core::glam::Vec3;
use halflight_core::scene::Scene;
use halflight_core::stats::{
    CertificateCounts, FragmentCounts, FrameStats, RayCounts, StageTimes, VisibilityStats,
};
use halflight_cpu::bvh::Bvh;
use halflight_cpu::config::{Named, PipelineConfig};
use halflight_cpu::pipeline::{Image, Pipeline};
use halflight_cpu::voxel::VoxelConfig;
use halflight_image::{ExrFile, RGB, memory, picture};
use halflight_lab::program::{print, say};
use halflight_lab::unlit::unlit;
use halflight_lab::voxel_errors::failures;
use halflight_metrics::{write_file, write_png};
use serde::Serialize;
use serde_json::{Value, json};

use crate::Outcome;
use crate::args::Render;
use crate::config::configure;
use crate::frames::{self, Moment};
#[cfg(feature = "gpu")]
use crate::gpu;
use crate::outputs;
use crate::scene;
use crate::voxel_errors::{self, VoxelFailures};

/// Everything about a frame but the image.
#[derive(Serialize)]
struct Stats<'a> {
    config: &'a PipelineConfig,
    #[serde(flatten)]
    moment: Option<Moment>,
    fragments: &'a FragmentCounts,
    rays: &'a RayCounts,
    visibility: &'a VisibilityStats,
    proofs: &'a CertificateCounts,
    #[serde(skip_serializing_if = "Option::is_none")]
    expected_nmse2: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    voxel_failures: Option<VoxelFailures>,
    stages_ms: &'a StageTimes,
    total_ms: f64,
    build_ms: f64,
    peak_bytes: u64,
}

/// A frame to be written.
#[derive(Clone, Copy)]
pub(crate) struct Frame<'a> {
    image: &'a Image,
    gbuffer: &'a GBuffer,
    /// None from a GPU.
    fragments: Option<&'a Fragments>,
}

impl<'a> Frame<'a> {
    /// The last one of a pipeline.
    pub(crate) fn of(pipeline: &'a Pipeline) -> Self {
        Self { image: pipeline.image(), gbuffer: pipeline.gbuffer(), fragments: Some(pipeline.fragments()) }
    }
}

/// A frame from a GPU.
#[cfg(feature = "gpu")]
pub(crate) struct Rendered {
    pub(crate) image: Image,
    pub(crate) gbuffer: GBuffer,
    /// The device's name.
    pub(crate) device: String,
}

/// Bytes a pixel of an image with all layers while it is written: 23 channels, as values and compressed.
const LAYERS: u64 = 180;

/// Bytes a pixel of a failure map while it is made.
const FAILURES: u64 = 170;

/// Bytes a pixel of an image and a G-buffer that come from a GPU.
const DOWNLOADED: u64 = 80;

/// What is rendered, how and where to.
pub(crate) struct Job<'a> {
    /// Options, with the output that there is by default.
    pub(crate) args: &'a Render,
    /// Files that are read.
    inputs: Vec<PathBuf>,
    /// The scene as the command line names it.
    pub(crate) name: &'a str,
    pub(crate) config: PipelineConfig,
    /// The backend whose failures are mapped.
    voxels: Option<VoxelConfig>,
    build_ms: f64,
}

pub(crate) fn run(mut args: Render) -> Outcome {
    let config = configure(&args.choices)?;
    if args.print_config {
        return Ok(print(&toml::to_string(&config)?)?);
    }
    // The command line asks for a scene wherever it gets here.
    let name = &args.scene.clone().unwrap_or_default();
    let voxels = args.voxel_error_map.as_ref().map(|_| voxel_errors::voxels(&config)).transpose()?;
    if args.outputs().is_empty() {
        args.png = Some(PathBuf::from(format!("{}.png", scene::stem(name))));
    }
    let inputs = scene::file(name).into_iter().chain(args.choices.config.clone()).collect();
    let first = args.frames.as_ref().map(|frames| Moment::numbered(frames.start));
    let mut job = Job { args: &args, inputs, name, config, voxels, build_ms: 0.0 };
    job.check(first)?;
    if args.choices.device != "cpu" && (args.frames.is_some() || args.voxel_error_map.is_some()) {
        return Err("--frames and --voxel-error-map are for the CPU: leave out --device".into());
    }
    let ready = scene::load(name)?;
    job.build_ms = ready.bvh.build_time().as_secs_f64() * 1e3;
    job.inputs.extend(ready.files(name));
    job.check(first)?;
    #[cfg(feature = "gpu")]
    if args.choices.device == "gpu" {
        job.check_memory()?;
        let rendered = gpu::render(&ready.scene, &config)?;
        let Rendered { image, gbuffer, device } = &rendered;
        say(&summary(&format!("{name} on {device}"), &config, &image.stats, job.build_ms));
        let frame = Frame { image, gbuffer, fragments: None };
        return job.finish(&frame, &ready);
    }
    let builder = config.builder(Arc::clone(&ready.scene), Arc::clone(&ready.bvh));
    let mut pipeline = builder.layers(args.out.is_some()).build()?;
    job.check_memory()?;
    if let Some(frames) = &args.frames {
        return frames::run(&job, frames.clone(), &ready, &mut pipeline);
    }
    pipeline.render()?;
    say(&summary(name, &config, &pipeline.image().stats, job.build_ms));
    job.finish(&Frame::of(&pipeline), &ready)
}

impl Job<'_> {
    /// Writes a scene's only frame and says where to.
    fn finish(&self, frame: &Frame, ready: &scene::Ready) -> Outcome {
        outputs::say_written(&self.write(frame, &ready.scene, &ready.bvh, None)?);
        Ok(())
    }

    /// Refuses outputs that cannot be written, or would overwrite each other or what is read.
    pub(crate) fn check(&self, moment: Option<Moment>) -> Outcome {
        let mut outputs = self.args.outputs();
        outputs.iter_mut().for_each(|(_, path)| *path = file(path, moment));
        outputs::check(&outputs, &self.inputs)
    }

    /// Refuses images that do not fit into memory.
    fn check_memory(&self) -> Outcome {
        let args = self.args;
        let PipelineConfig { width, height, refiner, .. } = self.config;
        let pixels = u64::from(width) * u64::from(height);
        let frame = match args.choices.device.as_str() {
            "cpu" => self.config.bytes_needed(),
            _ => pixels.saturating_mul(DOWNLOADED),
        };
        let outputs = [(args.out.is_some(), LAYERS), (args.voxel_error_map.is_some(), FAILURES)];
        let bytes: u64 = outputs.iter().filter(|(asked, _)| *asked).map(|(_, bytes)| bytes).sum();
        let needed = frame.saturating_add(pixels.saturating_mul(bytes));
        memory::check(format!("an image of {width}x{height} pixels ({})", refiner.name()), needed)
            .map_err(|fault| format!("{fault}; choose a smaller --size").into())
    }

    /// Writes a frame, `moment` of an animation, to all files that are asked for, and returns their names.
    pub(crate) fn write(
        &self,
        frame: &Frame,
        scene: &Scene,
        bvh: &Arc<Bvh>,
        moment: Option<Moment>,
    ) -> Result<Vec<PathBuf>, Box<dyn std::error::Error>> {
        let (args, config) = (self.args, &self.config);
        let Frame { image, gbuffer, fragments } = *frame;
        let file = |path: &PathBuf| file(path, moment);
        if let Some(reason) = unlit(scene, gbuffer, &image.irradiance) {
            say(&format!("warning: {reason}"));
        }
        let mut written = Vec::new();
        if let Some(path) = args.out.as_ref().map(file) {
            layers(frame, self.name, config, moment)?.write(&path)?;
            written.push(path);
        }
        let (width, height) = (config.width, config.height);
        if let Some(path) = args.png.as_ref().map(file) {
            let rgb = picture::image(&image.irradiance, &gbuffer.albedo, args.exposure);
            write_png(&path, width, height, &rgb)?;
            written.push(path);
        }
        if let Some(path) = args.fragment_map.as_ref().map(file) {
            let rgb = match fragments {
                Some(fragments) => picture::fragment_map(fragments, gbuffer),
                None => picture::level_map(&image.level, gbuffer),
            };
            write_png(&path, width, height, &rgb)?;
            written.push(path);
        }
        let mut voxel_failures = None;
        if let (Some(path), Some(voxels)) = (args.voxel_error_map.as_ref().map(file), self.voxels) {
            let found = failures(scene, bvh, gbuffer, voxels, config.sampling, config.seed)?;
            let failures = VoxelFailures::new(&found);
            say(&failures.line());
            write_png(&path, width, height, &found.image)?;
            written.push(path);
            voxel_failures = Some(failures);
        }
        if let Some(path) = args.stats.as_ref().map(file) {
            let FrameStats {
                fragments,
                rays,
                visibility,
                proofs,
                expected_nmse2,
                stages_ms,
                total_ms,
                peak_bytes,
            } = &image.stats;
            let stats = Stats {
                config,
                moment,
                fragments,
                rays,
                visibility,
                proofs,
                expected_nmse2: *expected_nmse2,
                voxel_failures,
                stages_ms,
                total_ms: *total_ms,
                build_ms: self.build_ms,
                peak_bytes: *peak_bytes,
            };
            let text = serde_json::to_string_pretty(&stats)?;
            write_file(&path, (text + "\n").as_bytes())?;
            written.push(path);
        }
        Ok(written)
    }
}

/// A file of a frame, or of the only one.
fn file(path: &Path, moment: Option<Moment>) -> PathBuf {
    moment.map_or_else(|| path.to_owned(), |moment| moment.file(path))
}

/// The frame with all its layers.
fn layers(
    frame: &Frame,
    scene: &str,
    config: &PipelineConfig,
    moment: Option<Moment>,
) -> serde_json::Result<ExrFile> {
    let Frame { image, gbuffer, .. } = *frame;
    // By way of text, which has 0.05 where the nearest f64 of an f32 is 0.05000000074505806.
    let config: Value = serde_json::from_str(&serde_json::to_string(config)?)?;
    let mut metadata = json!({
        "program": crate::PROGRAM,
        "commit": crate::COMMIT,
        "scene": scene,
        "config": config,
    });
    if let Some(moment) = moment {
        metadata["moment"] = json!({ "frame": moment.frame, "time_s": moment.time_s });
    }
    let mut file = ExrFile::new(image.width, image.height, metadata);
    file.add_light(&image.irradiance, &gbuffer.albedo);
    // GPUs keep no visible part.
    if !image.visibility.is_empty() {
        let visibility: Vec<Vec3> = image.visibility.iter().map(|&part| Vec3::splat(part)).collect();
        file.add_vectors("visibility", RGB, &visibility);
    }
    file.add_geometry(gbuffer);
    // -1 where nothing is seen, although cells may reach there.
    let level =
        |(pixel, &level): (usize, &u8)| if gbuffer.is_receiver(pixel) { f32::from(level) } else { -1.0 };
    file.add_plane("level", "Y", image.level.iter().enumerate().map(level).collect());
    Ok(file)
}

/// A short account for people.
fn summary(scene: &str, config: &PipelineConfig, stats: &FrameStats, build_ms: f64) -> String {
    let StageTimes { gbuffer, pyramid, refine, visibility, prove, irradiance, upsample, compose } =
        stats.stages_ms;
    let stages = [
        ("gbuffer", gbuffer),
        ("pyramid", pyramid),
        ("refine", refine),
        ("visibility", visibility),
        ("prove", prove),
        ("irradiance", irradiance),
        ("upsample", upsample),
        ("compose", compose),
        ("total", stats.total_ms),
    ];
    let PipelineConfig { width, height, refiner, visibility, upsampler, sampling, .. } = config;
    let mut lines = vec![format!(
        "{scene}, {width}x{height}: {}, {}, {}, {} light samples",
        refiner.name(),
        visibility.name(),
        upsampler.name(),
        sampling.count
    )];
    lines.extend(stages.iter().map(|(name, ms)| format!("  {name:<10} {ms:>9.1} ms")));
    let by_level = |counts: &[u64]| {
        let used = counts.iter().rposition(|&count| count > 0).map_or(0, |last| last + 1);
        counts[..used].iter().map(ToString::to_string).collect::<Vec<_>>().join(" ")
    };
    let FragmentCounts { total, per_level, cells } = &stats.fragments;
    lines.push(format!("  fragments  {total} (by level: {})", by_level(per_level)));
    if cells != per_level && cells.iter().any(|&count| count > 0) {
        lines.push(format!("  cells      {} (by level: {})", cells.iter().sum::<u64>(), by_level(cells)));
    }
    let RayCounts { refine, last, skipped, total } = stats.rays;
    lines.push(format!("  rays       {total} ({refine} to refine, {last} final; {skipped} skipped)"));
    let VisibilityStats { prepare_ms, lit, umbra, spared, listed, walked, left_to_rays, pairs, kept, .. } =
        stats.visibility;
    if stats.visibility.receivers() > 0 {
        lines.push(format!(
            "  beams      {listed} receivers by shared lists, {walked} by walks, {left_to_rays} left to rays; proved: {lit} \
             lit, {umbra} umbra, {spared} rays spared"
        ));
    }
    if pairs > 0 {
        lines.push(format!("  pairs      {pairs}, {kept} kept; binned in {prepare_ms:.1} ms"));
    }
    let CertificateCounts { lit, umbra, bounded, traced } = stats.proofs;
    let pixels = lit + umbra + bounded + traced;
    if pixels > 0 {
        let share = |count: u64| 100.0 * count as f64 / pixels as f64;
        lines.push(format!(
            "  proved     {:.1} % of the receivers: {:.1} % lit, {:.1} % umbra, {:.1} % bounded; the others traced",
            share(lit + umbra + bounded),
            share(lit),
            share(umbra),
            share(bounded)
        ));
    }
    if let Some(error) = stats.expected_nmse2 {
        lines.push(format!("  expected   NMSE2 {error:.1e}"));
    }
    // Memory of a GPU is not counted.
    if stats.peak_bytes > 0 {
        lines.push(format!("  memory     {:.1} MiB", stats.peak_bytes as f64 / f64::from(1 << 20)));
    }
    lines.push(format!("  BVH  built in {build_ms:.1} ms"));
    lines.join("\n")
}
