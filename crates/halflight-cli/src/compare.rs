//! `halflight compare`.

use halflight_lab::exr_file::{self, ExrFile};
use halflight_lab::picture;
use halflight_metrics::{Comparison, Image, compare, write_png};

use crate::Outcome;
use crate::args::Compare;
use crate::terminal::print;

pub(crate) fn run(args: &Compare) -> Outcome {
    let (image, reference) = (exr_file::read(&args.image)?, exr_file::read(&args.reference)?);
    let (pixels, truth) = (image.layer(&args.layer)?, reference.layer(&args.layer)?);
    let mask = mask(&reference);
    let image = Image::new(image.width, image.height, &pixels)?;
    let mut reference = Image::new(reference.width, reference.height, &truth)?;
    if let Some(mask) = &mask {
        reference = reference.with_mask(mask)?;
    }
    let errors = compare(image, reference)?;
    if let Some(path) = &args.error_map {
        let rgb = picture::error(image, reference, args.scale)?;
        write_png(path, image.width(), image.height(), &rgb)?;
    }
    print(&if args.json { serde_json::to_string_pretty(&errors)? + "\n" } else { table(&errors) })
}

/// The pixels that take part: those that see something, where the file tells.
fn mask(reference: &ExrFile) -> Option<Vec<bool>> {
    let depth = reference.plane("depth", "Z").ok()?;
    Some(depth.iter().map(|depth| depth.is_finite()).collect())
}

fn table(errors: &Comparison) -> String {
    let Comparison { sse, nmse, nmse2, rmse, relmse, max, psnr, ssim, flip } = errors;
    let rows = [
        ("sse", sse),
        ("nmse", nmse),
        ("nmse2", nmse2),
        ("rmse", rmse),
        ("relmse", relmse),
        ("max", max),
        ("psnr", psnr),
        ("ssim", ssim),
        ("flip", flip),
    ];
    let row = |(name, value): (&str, &f64)| {
        // Errors span many decades, the last three do not.
        match name {
            "psnr" | "ssim" | "flip" => format!("{name:<7} {value:.4}\n"),
            _ => format!("{name:<7} {value:.4e}\n"),
        }
    };
    rows.into_iter().map(row).collect()
}
