//! Stages of one's own: a refiner, a visibility backend and an upsampler from outside the workspace.
//!
//! `cargo run --example custom_stages` renders a bundled scene with all three and prints what they did.

use halflight::prepared::PreparedScene;
use std::error::Error;
use std::sync::Arc;

use halflight::fragment::{Fragments, Sample};
use halflight::frame::Frame;
use halflight::mask::{MaskBatch, Purpose};
use halflight::pattern::Pattern;
use halflight::pipeline::Pipeline;
use halflight::rays::BvhRays;
use halflight::stages::{RefineOutput, Refiner, Unsupported, Upsampler, Visibility};

/// Fragments of one fixed size, sampled at their first receiver pixel.
struct Blocks {
    level: u8,
}

impl Refiner for Blocks {
    fn refine(
        &mut self,
        frame: &Frame,
        light: u32,
        visibility: &mut dyn Visibility,
        fragments: &mut Fragments,
    ) -> RefineOutput<'_> {
        let gbuffer = frame.gbuffer;
        let size = 1 << self.level;
        let batch = fragments.open_batch(frame.pattern, Purpose::Final);
        for y in 0..gbuffer.height.div_ceil(size) {
            for x in 0..gbuffer.width.div_ceil(size) {
                let pixels = (y * size..((y + 1) * size).min(gbuffer.height))
                    .flat_map(|py| (x * size..((x + 1) * size).min(gbuffer.width)).map(move |px| (px, py)));
                let found = pixels.into_iter().find_map(|(px, py)| {
                    let pixel = gbuffer.index(px, py);
                    Some((px, py, pixel as u32, gbuffer.receiver(pixel)?))
                });
                let Some((px, py, pixel, receiver)) = found else { continue };
                let queries = fragments.batch_mut(batch);
                let first = queries.len() as u32;
                queries.push(receiver.origin, receiver.normal, pixel, frame.key(light, pixel, pixel), None);
                let (x_centre, y_centre) = (px as f32 + 0.5, py as f32 + 0.5);
                let sample =
                    Sample { x: x_centre, y: y_centre, pixel, level: self.level, probes: 1, batch, first };
                let sample = fragments.push_sample(sample);
                fragments.push_cell(self.level, x, y, &[sample]);
            }
        }
        visibility.masks(frame, fragments.batch_mut(batch));
        RefineOutput::default()
    }
}

/// Answers as the rays do, for up to 64 samples, and counts its queries.
struct Counting {
    rays: BvhRays,
    queries: usize,
}

impl Visibility for Counting {
    fn masks(&mut self, frame: &Frame, batch: &mut MaskBatch) {
        self.queries += batch.len();
        self.rays.masks(frame, batch);
    }

    fn supports(&self, pattern: Pattern) -> Result<(), Unsupported> {
        if pattern.len() <= 64 {
            return Ok(());
        }
        Err(Unsupported::new("counting rays", pattern, "masks are one word here; use 64 samples or fewer"))
    }
}

/// Copies a cell's first sample into all of its pixels.
struct Flat;

impl Upsampler for Flat {
    fn upsample(&mut self, _frame: &Frame, fragments: &Fragments, values: &[f32], out: &mut [f32]) {
        out.fill(0.0);
        let width = fragments.width();
        for cell in fragments.cells() {
            let value = fragments.cell_samples(cell).first().map(|&sample| values[sample as usize]);
            // A value that does not exist is NaN.
            let value = value.filter(|value| !value.is_nan());
            let (x0, y0, x1, y1) = cell.pixels(width, fragments.height());
            for y in y0..y1 {
                out[(y * width + x0) as usize..(y * width + x1) as usize].fill(value.unwrap_or(0.0));
            }
        }
    }
}

/// Renders the `contact` scene with the three stages and returns a summary.
pub fn run() -> Result<String, Box<dyn Error>> {
    let scene = PreparedScene::new(halflight::scene_file::load_bundled("contact")?.scene)?;
    let builder = || {
        Pipeline::builder(&scene)
            .size(160, 120)
            .refiner(Blocks { level: 2 })
            .visibility(Counting { rays: BvhRays::new(Arc::clone(scene.bvh())), queries: 0 })
            .upsampler(Flat)
    };
    let mut pipeline = builder().build()?;
    let image = pipeline.render()?;
    let mean: f32 =
        image.irradiance.iter().map(|v| v.element_sum() / 3.0).sum::<f32>() / image.irradiance.len() as f32;
    let stats = &image.stats;

    // A combination that cannot work is refused when it is built, not in the middle of a frame.
    let sampling = halflight::frame::LightSampling { count: 256, ..Default::default() };
    let refusal = match builder().sampling(sampling).build() {
        Ok(_) => return Err("256 samples should have been refused".into()),
        Err(error) => error.to_string(),
    };
    Ok(format!(
        "{} fragments, {} rays, mean irradiance {mean:.3} W/m²; 256 samples: {refusal}",
        stats.fragments.total, stats.rays.total
    ))
}

fn main() -> Result<(), Box<dyn Error>> {
    println!("{}", run()?);
    Ok(())
}
