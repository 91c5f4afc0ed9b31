//! Smoothing of visible fractions: samples are averaged with others on the same surface as far as their noise explains the differences.
//!
//! Masks of neighbouring receivers have independent noise, which shows as blotches between corners. A penumbra is smooth
//! at the scale of its width, so that two samples on opposite sides of a third average to its fraction: such a pair has
//! no error from a gradient, and one from a curvature shows when pairs are compared. Pairs are taken along four directions, each
//! as far as its pairs agree with what is known so far. Directional windows by comparison of estimates with their confidence intervals are those of
//! Katkovnik, Foi, Egiazarian and Astola 2010, "From Local Kernel to Nonlocal Multiple-Model Image Denoising", section 4.

use halflight_core::fragment::{Fragments, Sample};
use rayon::prelude::*;

use super::{Lattice, NONE, View};

/// Distances of the samples of a pair from the one between them, pixels.
const STRIDES: [i32; 5] = [1, 2, 4, 8, 16];

/// Directions of pairs.
const DIRECTIONS: [(i32, i32); 4] = [(1, 0), (0, 1), (1, 1), (1, -1)];

/// Most standard deviations by which a pair differs from a single sample, and from the mean of several.
const FROM_ONE: f32 = 3.0;
const FROM_SEVERAL: f32 = 2.0;

/// Visible fraction and its expected squared error.
#[derive(Clone, Copy, Debug)]
pub(super) struct Estimate {
    fraction: f32,
    variance: f32,
    /// Bit `4 · stride + direction` of every pair that it is a mean of, by their indices.
    pairs: u32,
}

/// Sum of fractions and of their expected squared errors.
#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    fractions: f32,
    variances: f32,
    count: f32,
}

impl Sum {
    fn add(&mut self, other: Self) {
        self.fractions += other.fractions;
        self.variances += other.variances;
        self.count += other.count;
    }

    /// True if a pair differs from the mean no more than noise explains.
    fn agrees(&self, pair: &Self) -> bool {
        let difference = pair.fractions / pair.count - self.fractions / self.count;
        // Variances are estimates that depend on the fractions, so that their mean is taken.
        let variance = (self.variances + pair.variances) / (self.count + pair.count);
        let most = if self.count > 1.0 { FROM_SEVERAL } else { FROM_ONE };
        difference * difference <= most * most * variance * (1.0 / pair.count + 1.0 / self.count)
    }
}

impl Lattice {
    /// Replaces the visible fractions of all samples, and their expected errors, by smoothed ones.
    pub(super) fn denoise(&mut self, view: &View, fragments: &Fragments) {
        let mut estimates = std::mem::take(&mut self.estimates);
        let samples = fragments.samples().par_iter().zip(&self.fractions).zip(&self.variances);
        let smooth = |((sample, &fraction), &variance): ((&Sample, _), _)| {
            self.smoothed_estimate(view, sample.pixel, Estimate { fraction, variance, pairs: 0 })
        };
        samples.with_min_len(64).map(smooth).collect_into_vec(&mut estimates);
        if !self.colours.is_empty() {
            self.denoise_colours(view, fragments, &estimates);
        }
        for (estimate, (fraction, variance)) in
            estimates.iter().zip(self.fractions.iter_mut().zip(&mut self.variances))
        {
            (*fraction, *variance) = (estimate.fraction, estimate.variance);
        }
        self.estimates = estimates;
        self.smoothed = true;
        self.measured = None;
    }

    /// Replaces the visible fractions of the channels by means over those of the samples, found for all channels together, whose pairs agree in
    /// each channel as well: colours may change where their sum does not.
    fn denoise_colours(&mut self, view: &View, fragments: &Fragments, estimates: &[Estimate]) {
        let width = view.gbuffer.width as i32;
        let sum_of = |sample: u32, channel: usize| Sum {
            fractions: self.colours[sample as usize][channel],
            variances: self.variances[sample as usize],
            count: 1.0,
        };
        let mean = |(index, estimate): (u32, &Estimate)| {
            let pixel = fragments.samples()[index as usize].pixel as i32;
            let mut sums = [0, 1, 2].map(|channel| sum_of(index, channel));
            let mut pairs = estimate.pairs;
            while pairs != 0 {
                let at = pairs.trailing_zeros() as usize;
                pairs &= pairs - 1;
                let (dx, dy) = DIRECTIONS[at % DIRECTIONS.len()];
                let step = (dy * width + dx) * STRIDES[at / DIRECTIONS.len()];
                let [one, other] = [pixel + step, pixel - step].map(|pixel| self.corners[pixel as usize]);
                let pair = [0, 1, 2].map(|channel| {
                    let mut pair = sum_of(one, channel);
                    pair.add(sum_of(other, channel));
                    pair
                });
                if sums.iter().zip(&pair).all(|(sum, pair)| sum.agrees(pair)) {
                    sums.iter_mut().zip(pair).for_each(|(sum, pair)| sum.add(pair));
                }
            }
            sums.map(|sum| sum.fractions / sum.count)
        };
        let indices = (0..estimates.len() as u32).into_par_iter().zip(estimates).with_min_len(64);
        let colours = indices.map(mean).collect();
        self.colours = colours;
    }

    /// Smoothed estimate of a sample.
    fn smoothed_estimate(&self, view: &View, pixel: u32, own: Estimate) -> Estimate {
        if own.fraction.is_nan() {
            return own;
        }
        let mut sum = Sum { fractions: own.fraction, variances: own.variance, count: 1.0 };
        let mut varies = own.fraction > 0.0 && own.fraction < 1.0;
        let mut open = [true; DIRECTIONS.len()];
        let mut pairs = 0;
        for (ring_bits, stride) in (0..).step_by(DIRECTIONS.len()).zip(STRIDES) {
            let mut ring = Sum::default();
            let directions = DIRECTIONS.iter().zip(&mut open).enumerate().filter(|(_, (_, open))| **open);
            for (direction, (&(dx, dy), open)) in directions {
                let (dx, dy) = (dx * stride, dy * stride);
                let Some(a) = self.estimate_at(view, pixel, (dx, dy)) else { continue };
                let Some(b) = self.estimate_at(view, pixel, (-dx, -dy)) else { continue };
                let pair = Sum {
                    fractions: a.fraction + b.fraction,
                    variances: a.variance + b.variance,
                    count: 2.0,
                };
                *open = sum.agrees(&pair);
                if *open {
                    varies |= a.fraction != own.fraction || b.fraction != own.fraction;
                    ring.add(pair);
                    pairs |= 1 << (ring_bits + direction);
                }
            }
            sum.add(ring);
            // Most samples are in full light or in umbra, as their neighbours are.
            if !varies && ring.count > 0.0 {
                break;
            }
        }
        if !varies {
            return Estimate { variance: 0.0, ..own };
        }
        let variance = sum.variances / (sum.count * sum.count);
        Estimate { fraction: sum.fractions / sum.count, variance, pairs }
    }

    /// Estimate at an offset from a pixel, if there is a sample with a fraction on the same surface.
    fn estimate_at(&self, view: &View, pixel: u32, offset: (i32, i32)) -> Option<Estimate> {
        let gbuffer = view.gbuffer;
        let x = (pixel % gbuffer.width).checked_add_signed(offset.0).filter(|&x| x < gbuffer.width)?;
        let y = (pixel / gbuffer.width).checked_add_signed(offset.1).filter(|&y| y < gbuffer.height)?;
        let other = gbuffer.index(x, y);
        let sample = self.corners[other];
        let fraction = if sample == NONE { return None } else { self.fractions[sample as usize] };
        let apart = offset.0.unsigned_abs().max(offset.1.unsigned_abs());
        let usable = !fraction.is_nan() && !view.planes.is_discontinuity(pixel as usize, other, apart);
        usable.then(|| Estimate { fraction, variance: self.variances[sample as usize], pairs: 0 })
    }

    /// True if the nearest sample in any direction, on the same surface, sees some of the light.
    pub(super) fn is_beside_penumbra(&self, view: &View, pixel: u32) -> bool {
        let both = DIRECTIONS.into_iter().flat_map(|(dx, dy)| [(dx, dy), (-dx, -dy)]);
        both.into_iter().any(|(dx, dy)| {
            let nearest =
                STRIDES.iter().find_map(|stride| self.estimate_at(view, pixel, (dx * stride, dy * stride)));
            nearest.is_some_and(|estimate| estimate.fraction > 0.0)
        })
    }
}
