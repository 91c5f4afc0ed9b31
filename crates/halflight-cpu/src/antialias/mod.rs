//! Antialiasing: pixels that see several surfaces are the mean over sub-samples.
//!
//! 1. Edge pixels are found by comparison with their four neighbours (`edges`, `surfaces`).
//! 2. Sub-samples on the sides where these differ are primary rays (`rays`); the others count as the centre. Where all see the centre's surface
//!    the pixel is left as it is.
//! 3. A sub-sample takes its visible fraction from the nearest of the 3 × 3 pixels around it that sees its surface; where none does, one
//!    sub-sample of each such surface asks for a mask (`sources`).
//! 4. Unshadowed irradiance and albedo are the sub-sample's own (`light`).
//!
//! Sources do not depend on the light: only masks and sums are made once for each.

mod edges;
mod light;
mod rays;
mod sources;
mod surfaces;

use std::f32::consts::FRAC_1_PI;

use glam::{Vec2, Vec3};
use halflight_core::frame::Frame;
use halflight_core::mask::{MaskBatch, Purpose};
use halflight_core::stages::Visibility;
use halflight_core::stats::AntialiasCounts;
use halflight_core::subpixel::{self, SubSampleError};
use halflight_core::values::Values;
use rayon::prelude::*;

use crate::bvh::Bvh;
use crate::emission::SeenLights;
use crate::irradiance::{Shading, fraction, query_sums, sampled_texture};
use crate::specular::{LobeLight, Specular};
use crate::textured::{SeenTexture, StrataRadiance};
use edges::Edges;
use light::Lit;
use rays::SubSamples;
use sources::{Search, Source};
use surfaces::Surfaces;

/// Edge pixels that one thread works on at a time.
const TASK: usize = 64;

/// Edge pixels of a frame and their sub-samples, in buffers that are kept.
#[derive(Default)]
pub(crate) struct Antialias {
    /// Sub-samples of a pixel.
    count: u32,
    edges: Edges,
    samples: SubSamples,
    /// Sources of the sub-samples.
    sources: Vec<Source>,
    /// Sub-samples that ask for masks, and the places of their pixels among the edge pixels.
    asking: Vec<(usize, usize)>,
    batch: MaskBatch,
    /// Values of the sub-samples that have asked.
    own: Vec<Vec3>,
    /// Radiance of the edge pixels, W/m²/sr, summed over their sub-samples.
    sums: Vec<Vec3>,
    /// Part of it that lights emit; empty where the camera sees none.
    emitted: Vec<Vec3>,
    /// Offsets of the sub-samples of each pixel that were traced, a bit each; empty where the camera sees no light.
    traced: Vec<u16>,
    counts: AntialiasCounts,
}

impl Antialias {
    /// Finds the edge pixels of a frame and what their sub-samples see, `count` in a pixel. With the `irradiance` of the pixels, where it is
    /// known already, edges amid pixels that no light reaches are left out.
    ///
    /// # Errors
    /// Pixels cannot have so many sub-samples.
    pub(crate) fn prepare(
        &mut self,
        bvh: &Bvh,
        frame: &Frame,
        count: u32,
        irradiance: Option<&[Vec3]>,
    ) -> Result<(), SubSampleError> {
        let (gbuffer, offsets) = (frame.gbuffer, subpixel::offsets(count)?);
        self.count = count;
        let surfaces = Surfaces::new(frame);
        self.edges.find(gbuffer, &surfaces, irradiance);
        let edges = self.edges.all();
        self.samples.trace(bvh, frame, offsets, edges);
        let Self { samples, sources, .. } = self;
        let search = Search::new(&surfaces, gbuffer, offsets);
        sources.resize(samples.all().len(), Source::Whole);
        let tasks = samples.split(sources, TASK).zip(edges.par_chunks(TASK));
        tasks.for_each(|((starts, mut sources), edges)| {
            for (range, edge) in starts.windows(2).zip(edges) {
                let (out, rest) = std::mem::take(&mut sources).split_at_mut(range[1] - range[0]);
                let offsets = samples.all()[range[0]..range[1]].iter().map(|sample| sample.offset);
                search.find(edge.pixel, offsets, &samples.surfaces, range[0], out);
                sources = rest;
            }
        });
        self.sums.clear();
        self.sums.resize(edges.len(), Vec3::ZERO);
        self.counts = AntialiasCounts::default();
        self.counts.edge_pixels = edges.len() as u64;
        self.counts.sub_samples = self.sources.len() as u64;
        self.asking.clear();
        for (edge, range) in self.samples.starts().windows(2).enumerate() {
            let sources = &self.sources[range[0]..range[1]];
            self.counts.resolved_pixels += u64::from(sources[0] != Source::Whole);
            let own = |&(place, &source): &(usize, &Source)| source == Source::Own(place as u8);
            self.asking
                .extend(sources.iter().enumerate().filter(own).map(|(place, _)| (range[0] + place, edge)));
        }
        // After the choice of those that ask: others take their values.
        self.see_lights(frame, offsets);
        Ok(())
    }

    /// Gives sub-samples that see a light its radiance instead of that of their surfaces.
    fn see_lights(&mut self, frame: &Frame, offsets: &[Vec2]) {
        let (width, height) = (frame.gbuffer.width, frame.gbuffer.height);
        self.emitted.clear();
        self.traced.clear();
        let Some(lights) = SeenLights::new(frame.scene, width, height) else { return };
        self.emitted.resize(self.sums.len(), Vec3::ZERO);
        self.traced.resize(frame.gbuffer.pixels(), 0);
        let Self { samples, sources, sums, emitted, traced, .. } = self;
        for (edge, range) in samples.starts().windows(2).enumerate() {
            let range = range[0]..range[1];
            if sources.get(range.start).is_none_or(|&source| source == Source::Whole) {
                continue;
            }
            for entry in range {
                let sample = samples.all()[entry];
                let (pixel, offset) = (sample.pixel as usize, usize::from(sample.offset));
                traced[pixel] |= 1 << offset;
                let (x, y) = (pixel % width as usize, pixel / width as usize);
                let at = offsets[offset];
                if let Some(radiance) = lights.before(&samples.surfaces, entry, [x, y], at, at) {
                    sums[edge] += radiance;
                    emitted[edge] += radiance;
                    sources[entry] = Source::Background;
                }
            }
        }
    }

    /// Offsets of the sub-samples of each pixel that were traced, a bit each; empty where the camera sees no light.
    pub(crate) fn traced(&self) -> &[u16] {
        &self.traced
    }

    /// Adds one light, whose values at the pixels are `planes`.
    pub(crate) fn add_light(
        &mut self,
        frame: &Frame,
        number: u32,
        shading: Shading,
        texture: Option<&SeenTexture>,
        planes: &Values,
        visibility: &mut dyn Visibility,
    ) {
        self.ask(frame, number, shading, visibility);
        let Self { samples, sources, own, sums, .. } = self;
        let light = frame.light(number);
        let lit =
            Lit { light, shading, gbuffer: frame.gbuffer, planes, samples: &samples.surfaces, own, texture };
        let tasks = sums.par_chunks_mut(TASK).enumerate();
        tasks.for_each(|(task, sums)| {
            let starts = &samples.starts()[task * TASK..=task * TASK + sums.len()];
            lit.add(starts, sources, sums);
        });
    }

    /// Asks for the masks of surfaces that no pixel sees, and computes their values.
    fn ask(&mut self, frame: &Frame, number: u32, shading: Shading, visibility: &mut dyn Visibility) {
        let Self { samples, asking, batch, own, .. } = self;
        own.resize(samples.all().len(), Vec3::ZERO);
        if asking.is_empty() {
            return;
        }
        let (light, edges) = (frame.light(number), self.edges.all());
        let (positions, normals) = (&samples.surfaces.position, samples.surfaces.shading_normals());
        batch.reset(number, frame.pattern, Purpose::Final);
        let queries = batch.fill(asking.len()).par_iter_mut().zip(&*asking).with_min_len(1024);
        queries.for_each(|(query, &(sample, edge))| {
            let pixel = edges[edge].pixel;
            (query.origin, query.normal) = (positions[sample], normals[sample]);
            (query.pixel, query.key) = (pixel, frame.key(number, pixel, pixel));
        });
        visibility.masks(frame, batch);
        self.counts.masks += asking.len() as u64;
        let texture = frame.light_texture(number);
        let strata = texture.map(|texture| StrataRadiance::new(&texture, light.radiance, batch.pattern()));
        for (query, &(sample, _)) in asking.iter().enumerate() {
            own[sample] = match (shading, &strata, &texture) {
                (Shading::Ratio, Some(strata), _) => strata
                    .fractions(light, batch, query)
                    .and_then(|sums| sums.fractions())
                    .map_or(Vec3::ZERO, Vec3::from_array),
                (Shading::Ratio, None, _) => Vec3::splat(fraction(light, batch, query).unwrap_or(0.0)),
                (Shading::Sampled, _, Some(texture)) => sampled_texture(light, texture, batch, query, 1),
                (Shading::Sampled, _, None) => {
                    Vec3::splat(query_sums(light, batch, query, 1).sampled(light.frame_area()))
                }
            };
        }
    }

    /// Adds the specular radiance of one light, whose values at the pixels are known. Returns the number of shadow rays.
    pub(crate) fn add_specular(&mut self, light: &LobeLight, pixels: &Specular) -> u64 {
        let Self { samples, sources, sums, .. } = self;
        let add = |task: usize, sums: &mut [Vec3]| {
            let starts = &samples.starts()[task * TASK..=task * TASK + sums.len()];
            let mut rays = 0;
            for (sum, range) in sums.iter_mut().zip(starts.windows(2)) {
                for (entry, source) in (range[0]..range[1]).zip(&sources[range[0]..range[1]]) {
                    let source = match *source {
                        Source::Whole => break,
                        Source::Background => continue,
                        Source::Pixel(pixel) => Some(pixel as usize),
                        Source::Own(_) => None,
                    };
                    let (radiance, traced) = pixels.sub_sample(light, &samples.surfaces, entry, source);
                    *sum += radiance;
                    rays += traced;
                }
            }
            rays
        };
        sums.par_chunks_mut(TASK).enumerate().map(|(task, sums)| add(task, sums)).sum()
    }

    /// Adds indirect irradiance, known at the pixels. Sub-samples that no pixel nearby shares a surface with take that of their own pixel, or the mean of
    /// those around it where it has none.
    pub(crate) fn add_indirect(&mut self, indirect: &[Vec3], width: usize) {
        let Self { samples, sources, sums, edges, .. } = self;
        for (sum, (range, edge)) in sums.iter_mut().zip(samples.starts().windows(2).zip(edges.all())) {
            for (entry, source) in (range[0]..range[1]).zip(&sources[range[0]..range[1]]) {
                let pixel = match *source {
                    Source::Whole => break,
                    Source::Background => continue,
                    Source::Pixel(pixel) => pixel,
                    Source::Own(_) => edge.pixel,
                };
                let light = match indirect[pixel as usize] {
                    Vec3::ZERO => mean_around(indirect, width, pixel as usize),
                    light => light,
                };
                *sum += samples.surfaces.albedo[entry] * light * FRAC_1_PI;
            }
        }
    }

    /// Replaces the radiance of pixels that see several surfaces, and the part of it that lights emit, by means over their sub-samples. Returns
    /// counts.
    pub(crate) fn resolve(&self, radiance: &mut [Vec3], emission: &mut [Vec3]) -> AntialiasCounts {
        let part = 1.0 / self.count.max(1) as f32;
        let edges = self.samples.starts().windows(2).zip(self.edges.all()).zip(&self.sums).enumerate();
        for (number, ((range, edge), sum)) in edges {
            let emitted = self.emitted.get(number).copied().unwrap_or(Vec3::ZERO);
            if self.sources[range[0]] != Source::Whole {
                let centre = 1.0 - (range[1] - range[0]) as f32 * part;
                let radiance = &mut radiance[edge.pixel as usize];
                *radiance = *radiance * centre + *sum * part;
                if let Some(emission) = emission.get_mut(edge.pixel as usize) {
                    *emission = *emission * centre + emitted * part;
                }
            }
        }
        self.counts
    }

    /// Memory held, bytes.
    pub(crate) fn bytes(&self) -> usize {
        self.edges.bytes()
            + self.samples.bytes()
            + self.sources.capacity() * size_of::<Source>()
            + self.asking.capacity() * size_of::<(usize, usize)>()
            + self.batch.bytes()
            + self.own.capacity() * size_of::<Vec3>()
            + (self.sums.capacity() + self.emitted.capacity()) * size_of::<Vec3>()
            + self.traced.capacity() * size_of::<u16>()
    }
}

/// Mean of the values above 0 of the 3 × 3 pixels around one.
fn mean_around(values: &[Vec3], width: usize, pixel: usize) -> Vec3 {
    let (x, y) = (pixel % width, pixel / width);
    let (mut sum, mut count) = (Vec3::ZERO, 0.0);
    for y in y.saturating_sub(1)..=y + 1 {
        for x in x.saturating_sub(1)..=(x + 1).min(width - 1) {
            let value = values.get(y * width + x).copied().unwrap_or(Vec3::ZERO);
            if value != Vec3::ZERO {
                (sum, count) = (sum + value, count + 1.0);
            }
        }
    }
    if count > 0.0 { sum / count } else { Vec3::ZERO }
}
