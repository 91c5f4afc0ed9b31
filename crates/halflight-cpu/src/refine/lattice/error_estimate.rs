//! Estimates of a frame's error, and its sampling plan, from the masks traced so far.

use glam::Vec3;
use halflight_core::fragment::{Cell, Fragments, Sample};
use halflight_core::gbuffer::GBuffer;
use halflight_core::hash;
use halflight_core::light::AreaLight;
use halflight_core::mask::MaskBatch;
use halflight_core::values::NO_VALUE;
use rayon::prelude::*;

use super::view::View;
use super::{Lattice, NOISE_IN_VISIBLE_ERROR};
use crate::compose::luminance;
use crate::irradiance;
use crate::refine::target::{Budget, Neighbours, PilotSample, SamplingPlan};
use crate::textured::{ChannelSums, StrataRadiance, StrataTable};
use crate::unshadowed::{roughly_unshadowed, unshadowed_many};

/// Number of pixels whose unshadowed irradiance is computed together (`TOGETHER`), and number that fills a
/// vector (`VECTOR`).
const TOGETHER: usize = 64;
const VECTOR: usize = 16;

/// Number of traced pixels from which the noise of all is predicted: within 7 % of the prediction from all
/// pixels on seven scenes at two targets; a quarter as many are within 14 %.
const MEASURED: usize = 8192;

/// Reciprocal of the fraction of cells that may be added before the noise of all is measured again.
const FEW: usize = 16;

impl Lattice {
    /// Computes the visible fractions of all samples from `known` on, and for an error target also their
    /// unshadowed irradiance.
    pub(super) fn evaluate(&mut self, view: &View, known: usize, fragments: &Fragments) {
        self.evaluate_fractions(view, known, fragments);
        self.evaluate_unshadowed(view, fragments);
    }

    /// Computes the visible fractions of all samples from `known` on.
    pub(super) fn evaluate_fractions(&mut self, view: &View, known: usize, fragments: &Fragments) {
        let (samples, light) = (&fragments.samples()[known..], view.frame.light(view.light));
        self.fractions.resize(fragments.samples().len(), NO_VALUE);
        if let Some(texture) = view.frame.light_texture(view.light) {
            for batch in fragments.batches() {
                self.strata.add(&texture, light.radiance, batch.pattern());
            }
            let Self { strata, fractions, colours, .. } = self;
            colours.resize(fragments.samples().len(), [NO_VALUE; 3]);
            let places = fractions[known..].par_iter_mut().zip(&mut colours[known..]).zip(samples);
            places.with_min_len(256).for_each(|((fraction, colours), sample)| {
                let batch = fragments.batch(sample.batch);
                (*fraction, *colours) = by_channel(strata, light, batch, sample.first as usize);
            });
        } else {
            self.fractions[known..].par_iter_mut().zip(samples).with_min_len(256).for_each(
                |(fraction, sample)| {
                    let batch = fragments.batch(sample.batch);
                    *fraction = irradiance::fraction(light, batch, sample.first as usize).unwrap_or(NO_VALUE);
                },
            );
        }
        if self.bounds_visible_error() {
            let mut neighbours = std::mem::take(&mut self.neighbours);
            neighbours.clear();
            neighbours.extend(fragments.batches().iter().map(|batch| Neighbours::of(batch.pattern(), light)));
            self.variances.resize(fragments.samples().len(), 0.0);
            let strata = &self.strata;
            let variances = self.variances[known..].par_iter_mut().zip(&self.fractions[known..]);
            variances.zip(samples).with_min_len(256).for_each(|((variance, &fraction), sample)| {
                let batch = fragments.batch(sample.batch);
                let neighbours = &neighbours[usize::from(sample.batch)];
                let strata = strata.of(batch.pattern());
                *variance = noise_of(neighbours, strata, batch, sample.first as usize, fraction);
            });
            self.neighbours = neighbours;
        }
    }

    /// Computes the visible fractions of all queries of a batch, which belong to the samples with indices
    /// `samples`.
    pub(super) fn evaluate_batch(&mut self, view: &View, batch: &MaskBatch, samples: &[u32]) {
        let light = view.frame.light(view.light);
        if let Some(texture) = view.frame.light_texture(view.light) {
            self.strata.add(&texture, light.radiance, batch.pattern());
            let strata = &self.strata;
            let queries = (0..samples.len()).into_par_iter().with_min_len(256);
            let found = queries.map(|query| by_channel(strata, light, batch, query));
            let found: Vec<(f32, [f32; 3])> = found.collect();
            for (&sample, (fraction, colours)) in samples.iter().zip(found) {
                (self.fractions[sample as usize], self.colours[sample as usize]) = (fraction, colours);
            }
        } else {
            let fraction = |query| irradiance::fraction(light, batch, query).unwrap_or(NO_VALUE);
            let queries = (0..samples.len()).into_par_iter().with_min_len(256);
            queries.map(fraction).collect_into_vec(&mut self.renewed);
            for (&sample, &fraction) in samples.iter().zip(&self.renewed) {
                self.fractions[sample as usize] = fraction;
            }
        }
        if self.bounds_visible_error() {
            let (neighbours, strata) =
                (Neighbours::of(batch.pattern(), light), self.strata.of(batch.pattern()));
            for (query, &sample) in samples.iter().enumerate() {
                let fraction = self.fractions[sample as usize];
                self.variances[sample as usize] = noise_of(&neighbours, strata, batch, query, fraction);
            }
        }
    }

    /// Computes the unshadowed irradiance of samples that do not have it yet.
    fn evaluate_unshadowed(&mut self, view: &View, fragments: &Fragments) {
        let light = view.frame.light(view.light);
        let lit = self.unshadowed.len();
        if self.config.target <= 0.0 || lit >= fragments.samples().len() {
            return;
        }
        self.unshadowed.resize(fragments.samples().len(), 0.0);
        let samples = fragments.samples()[lit..].par_chunks(TOGETHER);
        let blocks = self.unshadowed[lit..].par_chunks_mut(TOGETHER).zip(samples);
        let exactly = !self.config.validate;
        blocks.with_min_len(16).for_each(|(out, samples)| {
            let pixels = samples.iter().map(|sample| sample.pixel);
            if exactly {
                irradiance_of(light, view.gbuffer, pixels, out);
            } else {
                rough_irradiance_of(light, view.gbuffer, pixels, out);
            }
        });
    }

    /// Computes the sampling plan from the masks of the corners traced so far.
    pub(super) fn plan(&mut self, view: &View, fragments: &Fragments) {
        let neighbours = Neighbours::of(self.plan.full, view.frame.light(view.light));
        let pilot = |(sample, (&fraction, &unshadowed)): (&Sample, (&f32, &f32))| {
            let (batch, query) = (fragments.batch(sample.batch), sample.first as usize);
            let (variance, disagreement) = neighbours.variance(batch, query, self.strata.of(batch.pattern()));
            PilotSample { unshadowed, fraction, variance, disagreement }
        };
        let known = self.fractions.par_iter().zip(&self.unshadowed);
        fragments.samples().par_iter().zip(known).map(pilot).collect_into_vec(&mut self.pilot);
        let bound = if self.bounds_visible_error() { self.config.visible_error } else { 0.0 };
        let least = Budget::least_side(bound, Budget::NOISY);
        self.plan = SamplingPlan::reach(self.config.target, least, view.frame.pattern.kind, &self.pilot);
        if self.bounds_visible_error() {
            let most = NOISE_IN_VISIBLE_ERROR * self.config.visible_error;
            self.plan = self.plan.with_visible_noise(most, &self.pilot, &mut self.sides);
        }
        if !self.config.validate {
            self.plan = self.plan.alike_everywhere();
        }
    }

    /// Predicted squared error of the irradiance by luminance, summed over all pixels: the noise of traced
    /// pixels, estimated from a subset where there are many, and the error of interpolated cells that
    /// validation has found.
    pub(super) fn predict_error(&mut self, view: &View, fragments: &Fragments) -> f64 {
        let measured = match self.measured {
            Some((cells, measured)) if (fragments.cells().len() - cells) * FEW < cells => measured,
            _ => self.measure(view, fragments),
        };
        let sum = measured.noise + self.error_of_cells(view);
        let texture = view.frame.light_texture(view.light).map_or(Vec3::ONE, |texture| texture.mean());
        sum * f64::from(luminance(view.frame.light(view.light).radiance * texture)).powi(2)
    }

    /// Sums up noise and energy over the traced pixels.
    pub(super) fn measure(&mut self, view: &View, fragments: &Fragments) -> Measured {
        let cells = fragments.cells();
        let stride = cells.len().div_ceil(MEASURED).max(1);
        let mut neighbours = std::mem::take(&mut self.neighbours);
        neighbours.clear();
        neighbours.extend(
            fragments
                .batches()
                .iter()
                .map(|batch| Neighbours::of(batch.pattern(), view.frame.light(view.light))),
        );
        let light = view.frame.light(view.light);
        let measure = |(number, group): (usize, &[Cell])| {
            let cell = group[hash::mix(number as u32) as usize % group.len()];
            let (&[index], 0) = (fragments.cell_samples(&cell), cell.level) else {
                return Measurement::default();
            };
            let sample = &fragments.samples()[index as usize];
            let (batch, query) = (fragments.batch(sample.batch), sample.first as usize);
            let variance = if self.smoothed {
                self.variances[index as usize]
            } else {
                neighbours[usize::from(sample.batch)]
                    .variance(batch, query, self.strata.of(batch.pattern()))
                    .0
            };
            let fraction = match self.fractions.get(index as usize) {
                Some(&fraction) => fraction.max(0.0),
                None => irradiance::fraction(light, batch, query).unwrap_or(0.0),
            };
            let count = group.len() as f64;
            Measurement {
                sample: index,
                variance: f64::from(variance) * count,
                energy: f64::from(fraction).powi(2) * count,
            }
        };
        let mut measurements = std::mem::take(&mut self.measurements);
        cells
            .par_chunks(stride)
            .enumerate()
            .with_min_len(256)
            .map(measure)
            .collect_into_vec(&mut measurements);
        measurements.retain(|one| one.energy > 0.0);
        let known = &self.unshadowed;
        let block = |block: &[Measurement]| {
            let mut unshadowed = [0.0; TOGETHER];
            if known.len() == fragments.samples().len() {
                for (unshadowed, one) in unshadowed.iter_mut().zip(block) {
                    *unshadowed = known[one.sample as usize];
                }
            } else {
                let pixels = block.iter().map(|one| fragments.samples()[one.sample as usize].pixel);
                irradiance_of(light, view.gbuffer, pixels, &mut unshadowed[..block.len()]);
            }
            let mut sum = Measured::default();
            for (one, unshadowed) in block.iter().zip(unshadowed) {
                let power = f64::from(unshadowed).powi(2);
                sum.noise += one.variance * power;
                sum.energy += one.energy * power;
                sum.noisy += if one.variance > 0.0 { stride as f64 } else { 0.0 };
            }
            sum
        };
        // Summation in a fixed order, for any number of threads.
        let blocks = measurements.par_chunks(TOGETHER).with_min_len(16).map(block).collect::<Vec<Measured>>();
        (self.measurements, self.neighbours) = (measurements, neighbours);
        let measured = blocks.into_iter().fold(Measured::default(), |a, b| Measured {
            noise: a.noise + b.noise,
            energy: a.energy + b.energy,
            noisy: a.noisy + b.noisy,
        });
        self.measured = Some((cells.len(), measured));
        measured
    }
}

/// Standard deviation of the fraction of a mask whose samples all agree, in samples.
const AGREED: f32 = 0.4;

/// Expected squared error of the visible fraction of a query, where those whose samples all agree are uncertain as well.
fn noise_of(
    neighbours: &Neighbours,
    strata: Option<&StrataRadiance>,
    batch: &MaskBatch,
    query: usize,
    fraction: f32,
) -> f32 {
    let partly = fraction > 0.0 && fraction < 1.0;
    let found = if partly { neighbours.variance(batch, query, strata).0 } else { 0.0 };
    found.max((AGREED / batch.pattern().len() as f32).powi(2))
}

/// Visible fractions of a query, of all its light and of its channels.
fn by_channel(strata: &StrataTable, light: &AreaLight, batch: &MaskBatch, query: usize) -> (f32, [f32; 3]) {
    let sums = strata.of(batch.pattern()).and_then(|strata| strata.fractions(light, batch, query));
    let of = |sums: ChannelSums| Some((sums.fraction()?, sums.fractions()?));
    sums.and_then(of).unwrap_or((NO_VALUE, [NO_VALUE; 3]))
}

/// Sums over the traced pixels, per radiance.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Measured {
    /// Expected squared error of the irradiance.
    pub(super) noise: f64,
    /// Square of the irradiance.
    pub(super) energy: f64,
    /// Number of pixels that have noise.
    pub(super) noisy: f64,
}

/// Pixel that represents several: its sample, and the variance and the square of its visible fraction, both
/// times their number.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Measurement {
    sample: u32,
    variance: f64,
    energy: f64,
}

/// Computes the unshadowed irradiance per radiance of up to [`TOGETHER`] pixels.
fn irradiance_of(light: &AreaLight, gbuffer: &GBuffer, pixels: impl Iterator<Item = u32>, out: &mut [f32]) {
    let (origins, normals, count) = receivers(gbuffer, pixels);
    let count = count.min(out.len());
    // Whole vectors are fastest.
    let whole = count.next_multiple_of(VECTOR);
    let mut unshadowed = [0.0; TOGETHER];
    unshadowed_many(light, &origins[..whole], &normals[..whole], &mut unshadowed[..whole]);
    out[..count].copy_from_slice(&unshadowed[..count]);
}

/// Approximates [`irradiance_of`] to within a few percent.
pub(super) fn rough_irradiance_of(
    light: &AreaLight,
    gbuffer: &GBuffer,
    pixels: impl Iterator<Item = u32>,
    out: &mut [f32],
) {
    let (origins, normals, count) = receivers(gbuffer, pixels);
    let count = count.min(out.len());
    roughly_unshadowed(light, &origins[..count], &normals[..count], &mut out[..count]);
}

/// Positions and shading normals of up to [`TOGETHER`] pixels, and their number. Entries without a receiver have the
/// position of the previous one and a zero normal.
fn receivers(
    gbuffer: &GBuffer,
    pixels: impl Iterator<Item = u32>,
) -> ([Vec3; TOGETHER], [Vec3; TOGETHER], usize) {
    let (mut origins, mut normals) = ([Vec3::ZERO; TOGETHER], [Vec3::ZERO; TOGETHER]);
    let (mut last, mut count) = (Vec3::ZERO, 0);
    for pixel in pixels.take(TOGETHER) {
        let pixel = pixel as usize;
        if gbuffer.is_receiver(pixel) {
            (last, normals[count]) = (gbuffer.position[pixel], gbuffer.shading_normals()[pixel]);
        }
        origins[count] = last;
        count += 1;
    }
    origins[count..].fill(last);
    (origins, normals, count)
}
