//! Antialiasing: pixels that see several surfaces are the mean over sub-samples.
//!
//! 1. Edge pixels are found by comparison with their four neighbours (`edges`, `surfaces`).
//! 2. Each of their sub-samples is a primary ray. Where all see the centre's surface the pixel is left as it is.
//! 3. A sub-sample takes its visible fraction from the nearest of the 3 × 3 pixels around it that sees its surface; where none does, one
//!    sub-sample of each such surface asks for a mask (`sources`).
//! 4. Unshadowed irradiance and albedo are the sub-sample's own (`light`).
//!
//! Sources do not depend on the light: only masks and sums are made once for each.

mod edges;
mod light;
mod sources;
mod surfaces;

use std::f32::consts::FRAC_1_PI;

use glam::{Vec2, Vec3};
use halflight_core::frame::Frame;
use halflight_core::gbuffer::GBuffer;
use halflight_core::mask::{MaskBatch, Purpose};
use halflight_core::stages::Visibility;
use halflight_core::stats::AntialiasCounts;
use halflight_core::subpixel::{self, SubSampleError};
use halflight_core::values::Values;
use rayon::prelude::*;

use crate::bvh::Bvh;
use crate::gbuffer::trace_sub_samples;
use crate::irradiance::{Shading, fraction, query_sums};
use edges::Edges;
use light::{Lit, Sums};
use sources::Source;
use surfaces::Surfaces;

/// Edge pixels that one thread lights at a time.
const TASK: usize = 64;

/// Edge pixels of a frame and their sub-samples, in buffers that are kept.
#[derive(Default)]
pub(crate) struct Antialias {
    offsets: &'static [Vec2],
    edges: Edges,
    /// Surfaces of the sub-samples: a row an edge pixel.
    samples: GBuffer,
    /// Sources of the sub-samples.
    sources: Vec<Source>,
    /// Sub-samples that ask for masks.
    asking: Vec<usize>,
    batch: MaskBatch,
    /// Values of the sub-samples that have asked.
    own: Vec<f32>,
    sums: Vec<Sums>,
    counts: AntialiasCounts,
}

impl Antialias {
    /// Finds the edge pixels of a frame and what their `count` sub-samples see.
    ///
    /// # Errors
    /// Pixels cannot have so many sub-samples.
    pub(crate) fn prepare(&mut self, bvh: &Bvh, frame: &Frame, count: u32) -> Result<(), SubSampleError> {
        self.offsets = subpixel::offsets(count)?;
        let size = (frame.gbuffer.width, frame.gbuffer.height);
        let surfaces = Surfaces::new(frame);
        self.edges.find(frame, &surfaces);
        let pixels = self.edges.pixels();
        trace_sub_samples(bvh, frame.scene, size, pixels, self.offsets, &mut self.samples);
        sources::find(frame, &surfaces, pixels, self.offsets, &self.samples, &mut self.sources);
        let own = |(at, &source): (usize, &Source)| {
            (source == Source::Own((at % self.offsets.len()) as u8)).then_some(at)
        };
        self.asking.clear();
        self.asking.extend(self.sources.iter().enumerate().filter_map(own));
        self.sums.clear();
        self.sums.resize(pixels.len(), Sums::default());
        let rows = self.sources.chunks(self.offsets.len());
        self.counts = AntialiasCounts::default();
        self.counts.edge_pixels = pixels.len() as u64;
        self.counts.resolved_pixels = rows.filter(|row| row[0] != Source::Whole).count() as u64;
        self.counts.sub_samples = self.samples.pixels() as u64;
        Ok(())
    }

    /// Adds one light, whose values at the pixels are `planes`.
    pub(crate) fn add_light(
        &mut self,
        frame: &Frame,
        number: u32,
        shading: Shading,
        planes: &Values,
        visibility: &mut dyn Visibility,
    ) {
        self.ask(frame, number, shading, visibility);
        let Self { offsets, samples, sources, own, sums, .. } = self;
        let (light, count) = (frame.light(number), offsets.len().max(1));
        let lit = Lit { light, shading, gbuffer: frame.gbuffer, planes, samples, own };
        let tasks = sums.par_chunks_mut(TASK).zip(sources.par_chunks(TASK * count)).enumerate();
        tasks.for_each(|(index, (sums, sources))| lit.add(index * TASK * count, sources, sums));
    }

    /// Asks for the masks of surfaces that no pixel sees, and computes their values.
    fn ask(&mut self, frame: &Frame, number: u32, shading: Shading, visibility: &mut dyn Visibility) {
        let Self { samples, asking, batch, own, .. } = self;
        own.resize(samples.pixels(), 0.0);
        if asking.is_empty() {
            return;
        }
        let (light, pixels, count) = (frame.light(number), self.edges.pixels(), self.offsets.len());
        let normals = samples.shading_normals();
        batch.reset(number, frame.pattern, Purpose::Final);
        batch.fill(asking.len()).par_iter_mut().zip(&*asking).with_min_len(1024).for_each(
            |(query, &sample)| {
                let pixel = pixels[sample / count];
                (query.origin, query.normal) = (samples.position[sample], normals[sample]);
                (query.pixel, query.key) = (pixel, frame.key(number, pixel, pixel));
            },
        );
        visibility.masks(frame, batch);
        self.counts.masks += asking.len() as u64;
        for (query, &sample) in asking.iter().enumerate() {
            own[sample] = match shading {
                Shading::Ratio => fraction(light, batch, query).unwrap_or(0.0),
                Shading::Sampled => query_sums(light, batch, query, 1).sampled(light.area()),
            };
        }
    }

    /// Replaces the irradiance of pixels that see several surfaces by the mean over their sub-samples, and writes the radiance of all
    /// pixels. Returns counts.
    pub(crate) fn resolve(
        &self,
        gbuffer: &GBuffer,
        irradiance: &mut [Vec3],
        radiance: &mut Vec<Vec3>,
    ) -> AntialiasCounts {
        radiance.resize(irradiance.len(), Vec3::ZERO);
        let pixels = radiance.par_iter_mut().zip(&*irradiance).zip(&gbuffer.albedo).with_min_len(4096);
        pixels.for_each(|((radiance, &light), &albedo)| *radiance = light * albedo * FRAC_1_PI);
        let share = 1.0 / self.offsets.len().max(1) as f32;
        let rows = self.sources.chunks(self.offsets.len().max(1)).zip(self.edges.pixels()).zip(&self.sums);
        for ((sources, &pixel), sums) in rows {
            if sources[0] != Source::Whole {
                irradiance[pixel as usize] = sums.irradiance * share;
                radiance[pixel as usize] = sums.radiance * share;
            }
        }
        self.counts
    }

    /// Memory held, bytes.
    pub(crate) fn bytes(&self) -> usize {
        self.edges.bytes()
            + self.samples.bytes()
            + self.sources.capacity() * size_of::<Source>()
            + self.asking.capacity() * size_of::<usize>()
            + self.own.capacity() * size_of::<f32>()
            + self.batch.bytes()
            + self.sums.capacity() * size_of::<Sums>()
    }
}
