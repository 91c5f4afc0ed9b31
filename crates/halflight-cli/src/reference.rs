//! `halflight reference`.

use std::path::Path;

use halflight_image::{DEFAULT_LAYER, ExrFile, RGB};
use halflight_lab::program::say;
use halflight_lab::reference::unlit::unlit;
use halflight_lab::reference::{ReferenceConfig, reference, seen};
use halflight_metrics::is_stream;
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::json;

use crate::Outcome;
use crate::args::Reference;
use crate::paths;
use crate::scene;

pub(crate) fn run(args: &Reference) -> Outcome {
    let name = &args.scene.scene;
    let output = [("--out", args.out.clone())];
    paths::check(&output, scene::file(name).as_slice())?;
    let ready = scene::load(name)?;
    paths::check(&output, &ready.files(name))?;
    let scene = &ready.prepared;
    let (width, height) = args.size;
    let config =
        ReferenceConfig { width, height, samples: args.samples, seed: args.seed, antialias: args.antialias };
    // Nothing is left beside a pipe or a device.
    let folder = args.out.parent().filter(|_| !is_stream(&args.out));
    let cache = args.cache.as_deref().or(folder).unwrap_or(Path::new(""));

    let style =
        ProgressStyle::with_template("{bar:40} {pos}/{len} samples a pixel, {elapsed} of about {duration}")?;
    let bar = ProgressBar::new(0).with_style(style);
    let mut start = None;
    let result = reference(scene, &config, Some(cache), &mut |done, total| {
        if start.is_none() {
            start = Some(done);
            bar.set_length(total.into());
            // Samples from an earlier run say nothing about the speed of this one.
            bar.reset_eta();
        }
        bar.set_position(done.into());
    });
    bar.finish_and_clear();
    let result = result?;

    let seen = seen(scene, [width, height]);
    let metadata = json!({
        "program": crate::PROGRAM,
        "commit": crate::COMMIT,
        "scene": name,
        "reference": {
            "width": width,
            "height": height,
            "samples": result.samples,
            "seed": args.seed,
            "antialias": args.antialias,
            "noise_nmse2": result.noise_nmse2,
        },
    });
    let mut file = ExrFile::new(width, height, metadata);
    file.add_visibility(&result.visibility);
    match result.radiance.is_empty() {
        true => file.add_light(&result.irradiance, &seen.albedo),
        // Irradiance of images is that of pixel centres, with which means over sub-samples cannot be compared.
        false if args.antialias == 1 => file.add_resolved_light(&result.irradiance, &result.radiance),
        false => ["radiance", DEFAULT_LAYER]
            .into_iter()
            .for_each(|layer| file.add_vectors(layer, RGB, &result.radiance)),
    }
    file.add_geometry(&seen);
    file.write(&args.out)?;
    if let Some(reason) = unlit(scene.scene(), &seen, &result.irradiance) {
        say(&format!("warning: {reason}"));
    }
    say(&format!(
        "wrote {}: {} samples a pixel, noise NMSE2 {:.2e}",
        paths::shown(&args.out),
        result.samples,
        result.noise_nmse2
    ));
    Ok(())
}
