//! `halflight compare`.

use std::error::Error;

use halflight_core::glam::Vec3;
use halflight_image::{
    DEFAULT_LAYER, ExrFile, INDIRECT_IRRADIANCE, VISIBILITY, Window, layer_in_words, memory, picture,
};
use halflight_lab::program::{print, say};
use halflight_metrics::{CompareError, Comparison, Image, compare, is_standard_output, write_png};

use crate::Outcome;
use crate::args::Compare;
use crate::paths;

/// Number of bytes a pixel that the measures take.
const MEASURES: u64 = 200;

pub(crate) fn run(args: &Compare) -> Outcome {
    let map_printed = args.error_map.as_ref().is_some_and(|path| is_standard_output(path));
    if map_printed && args.json {
        return Err("--json and --error-map both write to standard output: give the map a file".into());
    }
    let output: Vec<_> = args.error_map.iter().map(|path| ("--error-map", path.clone())).collect();
    paths::check(&output, &[args.image.clone(), args.reference.clone()])?;
    let pair = Pair::read(args)?;
    let Window { width, height, .. } = pair.window;
    let what = format!("comparing images of {width}x{height} pixels");
    memory::check(what, MEASURES.saturating_mul(u64::from(width) * u64::from(height)))?;
    let image = Image::new(width, height, &pair.image)?;
    let mut reference = Image::new(width, height, &pair.reference)?;
    if let Some(mask) = &pair.mask {
        reference = reference.with_mask(mask)?;
    }
    if let Some(fractions) = &pair.fractions {
        reference = reference.with_visible_fractions(fractions)?;
    }
    let errors = compare(image, reference).map_err(|error| in_picture(error, &pair.window))?;
    say(&pair.words);
    if let Some(reason) = no_grain(&errors, &pair).filter(|_| !args.json) {
        say(&reason);
    }
    if let Some(path) = &args.error_map {
        let rgb = picture::error(image, reference, args.scale)?;
        write_png(path, width, height, &rgb)?;
    }
    match (map_printed, args.json) {
        (true, _) => say(table(&errors).trim_end()),
        (false, true) => print(&(serde_json::to_string_pretty(&errors)? + "\n"))?,
        (false, false) => print(&table(&errors))?,
    }
    Ok(())
}

/// Layers of light that reaches the camera: pixels take part where the reference sees a surface at their centre, and where either image has
/// light. Of other layers, which are of surfaces at pixels' centres, only the former do.
const LIGHT: [&str; 3] = [DEFAULT_LAYER, "radiance", "emission"];

/// Images that are compared.
struct Pair {
    window: Window,
    image: Vec<Vec3>,
    reference: Vec<Vec3>,
    /// Pixels that take part, if the reference has depths.
    mask: Option<Vec<bool>>,
    /// Visible fractions of the light in the reference, if it has them.
    fractions: Option<Vec<f32>>,
    /// Account of it for people.
    words: String,
}

impl Pair {
    /// Reads the pixels that both files have of the layers to compare.
    fn read(args: &Compare) -> Result<Self, Box<dyn Error>> {
        let (image, reference) = (ExrFile::read(&args.image)?, ExrFile::read(&args.reference)?);
        let [layer, reference_layer] = layers(args.layer.as_deref(), &image, &reference);
        let (pixels, truth) = (image.layer(layer)?, reference.layer(reference_layer)?);
        let window = common_window(&image, &reference)?;
        let mut words = format!("compared: {}", layer_in_words(layer));
        if layer != reference_layer {
            words += &format!(" with {}", layer_in_words(reference_layer));
        }
        if image.window() != reference.window() {
            words += &format!("; {window}, which both files have");
        }
        let seen = reference.plane("depth", "Z").ok().map(|depth| reference.crop(depth, &window));
        let fractions = reference.layer(VISIBILITY).ok();
        let fractions = fractions.map(|layer| layer.iter().map(|channels| channels.x).collect::<Vec<_>>());
        let (pixels, truth) = (image.crop(&pixels, &window), reference.crop(&truth, &window));
        // Beside surfaces there are lamps, and parts of surfaces that the centre misses.
        let beside = |pixel: usize| {
            LIGHT.contains(&layer) && (pixels[pixel] != Vec3::ZERO || truth[pixel] != Vec3::ZERO)
        };
        let takes_part = |(pixel, depth): (usize, &f32)| depth.is_finite() || beside(pixel);
        Ok(Self {
            window,
            mask: seen.map(|depth| depth.iter().enumerate().map(takes_part).collect()),
            image: pixels,
            reference: truth,
            fractions: fractions.map(|fractions| reference.crop(&fractions, &window)),
            words,
        })
    }
}

/// Adds the place of the window to an error that names a pixel.
fn in_picture(error: CompareError, window: &Window) -> Box<dyn Error> {
    match error {
        CompareError::NotFinite { role, x, y, value } => {
            let (x, y) = (window.x + i64::from(x), window.y + i64::from(y));
            format!("pixel ({x}, {y}) of the {role} is not finite: {value}").into()
        }
        other => other.into(),
    }
}

/// Returns the layers to compare: those `asked` for, or the irradiance or else the indirect irradiance if both files have it, or those that all programs show.
fn layers<'a>(asked: Option<&'a str>, image: &'a ExrFile, reference: &'a ExrFile) -> [&'a str; 2] {
    let both = [image, reference];
    // References of indirect light have no other irradiance.
    let usual = ["irradiance", INDIRECT_IRRADIANCE];
    let found = || usual.into_iter().find(|layer| both.iter().all(|file| file.layer(layer).is_ok()));
    match asked.or_else(found) {
        Some(layer) => [layer; 2],
        None => both.map(|file| file.shown_layer.as_str()),
    }
}

/// Returns the pixels that both files have: all, or those of the one whose data window lies inside the other's.
fn common_window(image: &ExrFile, reference: &ExrFile) -> Result<Window, Box<dyn Error>> {
    let [a, b] = [image, reference].map(ExrFile::window);
    if a == b {
        return Ok(a);
    }
    let [frame, reference_frame] = [image.display, reference.display];
    if frame != reference_frame {
        return Err(match (frame.width, frame.height) == (reference_frame.width, reference_frame.height) {
            true => format!("the images differ in their display windows: {frame} against {reference_frame}"),
            false => format!(
                "the images differ in size: {}×{} against {}×{}",
                frame.width, frame.height, reference_frame.width, reference_frame.height
            ),
        }
        .into());
    }
    if a.contains(&b) {
        return Ok(b);
    }
    if b.contains(&a) {
        return Ok(a);
    }
    Err(format!(
        "the images differ in their data windows, and neither lies inside the other: {a} against {b}; pixels of the same \
         place are compared"
    )
    .into())
}

/// Returns why there is no grain, if there is none.
fn no_grain(errors: &Comparison, pair: &Pair) -> Option<String> {
    match (errors.grain, &pair.fractions) {
        (Some(_), _) => None,
        (None, None) => Some(format!(
            "no grain: the reference has no {}, which tells penumbrae",
            layer_in_words(VISIBILITY)
        )),
        (None, Some(_)) => Some("no grain: no pixel of the reference lies in a penumbra".to_owned()),
    }
}

fn table(errors: &Comparison) -> String {
    let &Comparison { sse, nmse, nmse2, rmse, relmse, max, psnr, ssim, flip, flip_p99, grain } = errors;
    // Errors span many decades, others do not.
    let wide = |value: f64| format!("{value:.4e}");
    let narrow = |value: f64| format!("{value:.4}");
    let rows = [
        ("sse", wide(sse)),
        ("nmse", wide(nmse)),
        ("nmse2", wide(nmse2)),
        ("rmse", wide(rmse)),
        ("relmse", wide(relmse)),
        ("max", wide(max)),
        ("psnr", narrow(psnr)),
        ("ssim", narrow(ssim)),
        ("flip", narrow(flip)),
        ("flip_p99", narrow(flip_p99)),
        ("grain", grain.map_or_else(|| "-".to_owned(), narrow)),
    ];
    rows.into_iter().map(|(name, value)| format!("{name:<9} {value}\n")).collect()
}
