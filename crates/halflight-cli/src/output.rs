//! Files of a rendered frame: image, picture, maps and statistics.

use std::path::PathBuf;

use halflight_core::fragment::Fragments;
use halflight_core::gbuffer::GBuffer;
use halflight_cpu::config::PipelineConfig;
use halflight_cpu::pipeline::{Image, Pipeline};
use halflight_cpu::prepared::PreparedScene;
use halflight_cpu::voxel::VoxelConfig;
use halflight_image::{ExrFile, picture};
use halflight_lab::program::say;
use halflight_lab::reference::unlit::unlit;
use halflight_lab::reference::voxel_errors::failures;
use halflight_metrics::{tone_map, write_file, write_png};
use serde_json::{Value, json};

use crate::Outcome;
use crate::args::Render;
use crate::moment::{Moment, file};
use crate::paths;
use crate::statistics::Statistics;
use crate::voxel_errors::VoxelFailures;

/// Rendered frame.
#[derive(Clone, Copy)]
pub(crate) struct Frame<'a> {
    pub(crate) image: &'a Image,
    pub(crate) gbuffer: &'a GBuffer,
    /// `None` from a GPU.
    pub(crate) fragments: Option<&'a Fragments>,
}

impl<'a> Frame<'a> {
    /// Returns the last frame of a pipeline.
    pub(crate) fn of(pipeline: &'a Pipeline) -> Self {
        Self { image: pipeline.image(), gbuffer: pipeline.gbuffer(), fragments: Some(pipeline.fragments()) }
    }
}

/// Files that `halflight render` is asked for, and what goes into them beside the frame.
pub(crate) struct Output<'a> {
    /// Options, with the file that is written where none is asked for.
    pub(crate) args: &'a Render,
    /// Files that are read.
    pub(crate) inputs: Vec<PathBuf>,
    /// Name of the scene on the command line.
    pub(crate) name: &'a str,
    pub(crate) config: PipelineConfig,
    /// Backend whose failures are mapped.
    pub(crate) voxels: Option<VoxelConfig>,
    pub(crate) build_ms: f64,
}

impl Output<'_> {
    /// Refuses outputs that cannot be written, or would overwrite each other or what is read.
    pub(crate) fn check(&self, moment: Option<Moment>) -> Outcome {
        let mut outputs = self.args.outputs();
        outputs.iter_mut().for_each(|(_, path)| *path = file(path, moment));
        paths::check(&outputs, &self.inputs)
    }

    /// Writes a frame, `moment` of an animation, to all files that are asked for. Returns their names.
    pub(crate) fn write(
        &self,
        frame: &Frame,
        scene: &PreparedScene,
        moment: Option<Moment>,
    ) -> Result<Vec<PathBuf>, Box<dyn std::error::Error>> {
        let (args, config) = (self.args, &self.config);
        let Frame { image, gbuffer, fragments } = *frame;
        let file = |path: &PathBuf| file(path, moment);
        if let Some(reason) = unlit(scene.scene(), gbuffer, &image.irradiance) {
            say(&format!("warning: {reason}"));
        }
        let mut written = Vec::new();
        if let Some(path) = args.out.as_ref().map(file) {
            layers(frame, self.name, config, moment)?.write(&path)?;
            written.push(path);
        }
        let (width, height) = (config.width, config.height);
        if let Some(path) = args.png.as_ref().map(file) {
            let rgb = match image.radiance.is_empty() {
                true => picture::image(&image.irradiance, &gbuffer.albedo, args.exposure),
                false => tone_map(&image.radiance, args.exposure),
            };
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
            let found = failures(scene, gbuffer, voxels, config.sampling, config.seed)?;
            let failures = VoxelFailures::new(&found);
            say(&failures.line());
            write_png(&path, width, height, &found.image)?;
            written.push(path);
            voxel_failures = Some(failures);
        }
        if let Some(path) = args.stats.as_ref().map(file) {
            let stats = Statistics::new(config, moment, &image.stats, voxel_failures, self.build_ms);
            let text = serde_json::to_string_pretty(&stats)?;
            write_file(&path, (text + "\n").as_bytes())?;
            written.push(path);
        }
        Ok(written)
    }
}

/// Returns the frame with all its layers.
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
    match image.radiance.is_empty() {
        true => file.add_light(&image.irradiance, &gbuffer.albedo),
        false => file.add_resolved_light(&image.irradiance, &image.radiance),
    }
    if !image.indirect.is_empty() {
        file.add_indirect(&image.irradiance, &image.indirect, &gbuffer.albedo);
    }
    if !(image.specular.is_empty() && image.emission.is_empty()) {
        let mut diffuse = picture::radiance(&image.irradiance, &gbuffer.albedo);
        let indirect = picture::radiance(&image.indirect, &gbuffer.albedo);
        diffuse.iter_mut().zip(indirect).for_each(|(diffuse, indirect)| *diffuse += indirect);
        file.add_parts(&diffuse, &image.specular, &image.emission);
    }
    // GPUs keep no visible part.
    if !image.visibility.is_empty() {
        file.add_visibility(&image.visibility);
    }
    file.add_geometry(gbuffer);
    // -1 where nothing is seen, although cells may reach there.
    let level =
        |(pixel, &level): (usize, &u8)| if gbuffer.is_receiver(pixel) { f32::from(level) } else { -1.0 };
    file.add_plane("level", "Y", image.level.iter().enumerate().map(level).collect());
    Ok(file)
}
