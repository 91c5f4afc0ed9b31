//! `halflight reference`.

use std::path::Path;

use halflight_core::gbuffer::GBuffer;
use halflight_image::{DEFAULT_LAYER, ExrFile, INDIRECT, INDIRECT_IRRADIANCE, RGB, picture};
use halflight_lab::program::say;
use halflight_lab::reference::bounce::{LIGHT_SAMPLES, one_bounce};
use halflight_lab::reference::unlit::unlit;
use halflight_lab::reference::{ReferenceConfig, ReferenceError, reference, seen};
use halflight_metrics::is_stream;
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::{Value, json};

use crate::Outcome;
use crate::args::Reference;
use crate::paths;
use crate::scene::{self, Ready};

pub(crate) fn run(args: &Reference) -> Outcome {
    let name = &args.scene.scene;
    let output = [("--out", args.out.clone())];
    paths::check(&output, scene::file(name).as_slice())?;
    let ready = scene::load(name)?;
    paths::check(&output, &ready.files(name))?;
    let (width, height) = args.size;
    let config =
        ReferenceConfig { width, height, samples: args.samples, seed: args.seed, antialias: args.antialias };
    // Nothing is left beside a pipe or a device.
    let folder = args.out.parent().filter(|_| !is_stream(&args.out));
    let cache = args.cache.as_deref().or(folder).unwrap_or(Path::new(""));
    match args.indirect {
        true => indirect(args, &ready, &config, cache),
        false => direct(args, &ready, &config, cache),
    }
}

/// Computes the reference of direct light.
fn direct(args: &Reference, ready: &Ready, config: &ReferenceConfig, cache: &Path) -> Outcome {
    let scene = &ready.prepared;
    let result = with_progress("samples", |progress| reference(scene, config, Some(cache), progress))?;
    let seen = seen(scene, [config.width, config.height]);
    let made = json!({
        "samples": result.samples,
        "antialias": config.antialias,
        "noise_nmse2": result.noise_nmse2,
    });
    let mut file = file(args, config, made);
    file.add_visibility(&result.visibility);
    match result.radiance.is_empty() {
        true => file.add_light(&result.irradiance, &seen.albedo),
        // Irradiance of images is that of pixel centres, with which means over sub-samples cannot be compared.
        false if config.antialias == 1 => file.add_resolved_light(&result.irradiance, &result.radiance),
        false => ["radiance", DEFAULT_LAYER]
            .into_iter()
            .for_each(|layer| file.add_vectors(layer, RGB, &result.radiance)),
    }
    let reason = unlit(scene.scene(), &seen, &result.irradiance);
    let words = format!("{} samples a pixel, noise NMSE2 {:.2e}", result.samples, result.noise_nmse2);
    finish(args, file, &seen, reason, &words)
}

/// Computes the reference of indirect light.
fn indirect(args: &Reference, ready: &Ready, config: &ReferenceConfig, cache: &Path) -> Outcome {
    let scene = &ready.prepared;
    let result = with_progress("rays", |progress| one_bounce(scene, config, Some(cache), progress))?;
    let seen = seen(scene, [config.width, config.height]);
    let made = json!({
        "indirect": "one diffuse reflection",
        "rays": result.rays,
        "light_samples": LIGHT_SAMPLES,
        "noise_nmse2": result.noise_nmse2,
    });
    let mut file = file(args, config, made);
    let radiance = picture::radiance(&result.irradiance, &seen.albedo);
    file.add_vectors(INDIRECT_IRRADIANCE, RGB, &result.irradiance);
    for layer in [INDIRECT, DEFAULT_LAYER] {
        file.add_vectors(layer, RGB, &radiance);
    }
    let black = result.irradiance.iter().all(|light| light.max_element() == 0.0);
    let reason = black.then(|| "no surface reflects light towards a visible one".to_owned());
    let words = format!("{} rays a pixel, noise NMSE2 {:.2e}", result.rays, result.noise_nmse2);
    finish(args, file, &seen, reason, &words)
}

/// Computes something with a bar that counts what is done of each pixel.
fn with_progress<T>(
    counted: &str,
    compute: impl FnOnce(&mut dyn FnMut(u32, u32)) -> Result<T, ReferenceError>,
) -> Result<T, Box<dyn std::error::Error>> {
    let template = format!("{{bar:40}} {{pos}}/{{len}} {counted} a pixel, {{elapsed}} of about {{duration}}");
    let bar = ProgressBar::new(0).with_style(ProgressStyle::with_template(&template)?);
    let mut start = None;
    let result = compute(&mut |done, total| {
        if start.is_none() {
            start = Some(done);
            bar.set_length(total.into());
            // Samples from an earlier run say nothing about the speed of this one.
            bar.reset_eta();
        }
        bar.set_position(done.into());
    });
    bar.finish_and_clear();
    Ok(result?)
}

/// Returns an image without layers whose metadata say how the reference was made.
fn file(args: &Reference, config: &ReferenceConfig, made: Value) -> ExrFile {
    let mut reference = json!({ "width": config.width, "height": config.height, "seed": config.seed });
    if let (Some(all), Value::Object(made)) = (reference.as_object_mut(), made) {
        all.extend(made);
    }
    let metadata = json!({
        "program": crate::PROGRAM,
        "commit": crate::COMMIT,
        "scene": args.scene.scene,
        "reference": reference,
    });
    ExrFile::new(config.width, config.height, metadata)
}

/// Writes the image with the layers of its surfaces, and says so. `unlit` is why it is black.
fn finish(
    args: &Reference,
    mut file: ExrFile,
    seen: &GBuffer,
    unlit: Option<String>,
    words: &str,
) -> Outcome {
    file.add_geometry(seen);
    file.write(&args.out)?;
    if let Some(reason) = unlit {
        say(&format!("warning: {reason}"));
    }
    say(&format!("wrote {}: {words}", paths::shown(&args.out)));
    Ok(())
}
