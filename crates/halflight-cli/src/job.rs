//! `halflight render`: options are checked before anything is loaded, and memory before anything is rendered.

use std::path::PathBuf;

use halflight_cpu::config::{IndirectConfig, Named, PipelineConfig};
use halflight_image::memory;
use halflight_lab::program::print;

use crate::Outcome;
use crate::args::Render;
use crate::config::configure;
use crate::moment::Moment;
use crate::output::Output;
use crate::{animate, render, scene, voxel_errors};

/// Bytes a pixel of an image with all layers while it is written: 23 channels, as values and compressed.
const LAYERS: u64 = 180;

/// Bytes a pixel of the layers of indirect light: 9 channels.
const INDIRECT: u64 = 72;

/// Bytes a pixel of a failure map while it is made.
const FAILURES: u64 = 170;

/// Bytes a pixel of an image and a G-buffer that come from a GPU, with the sums of sub-samples.
const DOWNLOADED: u64 = 104;

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
    let mut output = Output { args: &args, inputs, name, config, voxels, build_ms: 0.0 };
    output.check(first)?;
    if args.choices.device != "cpu" && (args.frames.is_some() || args.voxel_error_map.is_some()) {
        return Err("--frames and --voxel-error-map are for the CPU: leave out --device".into());
    }
    if args.choices.device != "cpu" && config.indirect != IndirectConfig::None {
        let name = config.indirect.name();
        return Err(format!(
            "indirect light ({name}) is computed on the CPU only: leave out --device, or choose --indirect none"
        )
        .into());
    }
    let ready = scene::load(name)?;
    output.build_ms = ready.prepared.bvh().build_time().as_secs_f64() * 1e3;
    output.inputs.extend(ready.files(name));
    output.check(first)?;
    #[cfg(feature = "gpu")]
    if args.choices.device == "gpu" {
        check_memory(&args, &config)?;
        return render::on_gpu(&output, &ready);
    }
    let builder = config.builder(&ready.prepared);
    let mut pipeline = builder.layers(args.out.is_some()).build()?;
    check_memory(&args, &config)?;
    match &args.frames {
        Some(frames) => animate::run(&output, frames.clone(), &ready, &mut pipeline),
        None => render::on_cpu(&output, &ready, &mut pipeline),
    }
}

/// Refuses images that do not fit into memory.
fn check_memory(args: &Render, config: &PipelineConfig) -> Outcome {
    let &PipelineConfig { width, height, refiner, .. } = config;
    let pixels = u64::from(width) * u64::from(height);
    let frame = match args.choices.device.as_str() {
        "cpu" => config.bytes_needed(),
        _ => pixels.saturating_mul(DOWNLOADED),
    };
    let indirect = args.out.is_some() && config.indirect != IndirectConfig::None;
    let outputs =
        [(args.out.is_some(), LAYERS), (indirect, INDIRECT), (args.voxel_error_map.is_some(), FAILURES)];
    let bytes: u64 = outputs.iter().filter(|(asked, _)| *asked).map(|(_, bytes)| bytes).sum();
    let needed = frame.saturating_add(pixels.saturating_mul(bytes));
    memory::check(format!("an image of {width}x{height} pixels ({})", refiner.name()), needed)
        .map_err(|fault| format!("{fault}; choose a smaller --size").into())
}
