//! Refiner with samples at cell corners that cells share: the extension contract must support it, and so must
//! every upsampler.

use std::collections::HashMap;

use halflight::config::{Named as _, RefinerConfig, UpsamplerConfig};
use halflight::fragment::{Fragments, Sample};
use halflight::frame::Frame;
use halflight::irradiance::Shading;
use halflight::mask::Purpose;
use halflight::refine::PerPixel;
use halflight::stages::{RefineOutput, Refiner, Visibility};
use halflight_tests::{Stage, blocker_over_floor, nmse2};

/// Refiner of 4 × 4 pixel cells with a sample at each corner; cells beside the background are single pixels.
struct Corners;

impl Refiner for Corners {
    fn refine(
        &mut self,
        frame: &Frame,
        light: u32,
        visibility: &mut dyn Visibility,
        fragments: &mut Fragments,
    ) -> RefineOutput<'_> {
        const LEVEL: u8 = 2;
        let gbuffer = frame.gbuffer;
        let batch = fragments.open_batch(frame.pattern, Purpose::Final);
        let mut known = HashMap::new();
        let mut sample_at = |fragments: &mut Fragments, x: u32, y: u32| -> Option<u32> {
            let pixel = gbuffer.index(x, y);
            let receiver = gbuffer.receiver(pixel)?;
            Some(*known.entry(pixel).or_insert_with(|| {
                let queries = fragments.batch_mut(batch);
                let first = queries.len() as u32;
                queries.push(receiver.origin, receiver.normal, pixel as u32, frame.shared_key(light), None);
                let (x, y) = (x as f32 + 0.5, y as f32 + 0.5);
                fragments.push_sample(Sample {
                    x,
                    y,
                    pixel: pixel as u32,
                    level: LEVEL,
                    probes: 1,
                    batch,
                    first,
                })
            }))
        };
        for y in 0..gbuffer.height.div_ceil(1 << LEVEL) {
            for x in 0..gbuffer.width.div_ceil(1 << LEVEL) {
                let (x0, y0) = (x << LEVEL, y << LEVEL);
                let (x1, y1) = ((x0 + 4).min(gbuffer.width - 1), (y0 + 4).min(gbuffer.height - 1));
                let corners = [(x0, y0), (x1, y0), (x0, y1), (x1, y1)];
                let samples: Vec<u32> =
                    corners.iter().filter_map(|&(x, y)| sample_at(fragments, x, y)).collect();
                if samples.len() == 4 {
                    fragments.push_cell(LEVEL, x, y, &samples);
                    continue;
                }
                for y in y0..(y0 + 4).min(gbuffer.height) {
                    for x in x0..(x0 + 4).min(gbuffer.width) {
                        if let Some(sample) = sample_at(fragments, x, y) {
                            fragments.push_cell(0, x, y, &[sample]);
                        }
                    }
                }
            }
        }
        visibility.masks(frame, fragments.batch_mut(batch));
        RefineOutput::default()
    }

    fn coarsest_level(&self) -> u8 {
        0
    }
}

#[test]
fn corner_samples_go_through_every_upsampler() {
    let stage = Stage::new(blocker_over_floor()).unwrap();
    let mut per_pixel = stage.builder().size(160, 120).refiner(PerPixel::default()).build().unwrap();
    let reference = per_pixel.render().unwrap().clone();
    for upsampler in UpsamplerConfig::all() {
        for shading in [Shading::Sampled, Shading::Ratio] {
            let builder = stage.builder().size(160, 120).refiner(Corners).shading(shading);
            let mut pipeline =
                builder.boxed_upsampler(upsampler.stage(&RefinerConfig::default())).build().unwrap();
            let image = pipeline.render().unwrap().clone();
            assert!(image.irradiance.iter().all(|v| v.is_finite()), "{upsampler:?}");
            let error = nmse2(&image, &reference);
            // Cells of 4 × 4 pixels blur the penumbra; the Gaussian RBFs are not designed for corners and
            // must only stay finite.
            let faithful =
                matches!(upsampler, UpsamplerConfig::RbfFixed(_) | UpsamplerConfig::RbfAdaptive(_));
            assert!(error < if faithful { 0.5 } else { 0.02 }, "{upsampler:?} {shading:?}: {error}");
            let fragments = pipeline.fragments();
            let refers: usize = fragments.cells().iter().map(|cell| fragments.cell_samples(cell).len()).sum();
            assert!(refers > 2 * fragments.samples().len(), "samples are shared between cells");
        }
    }
}
