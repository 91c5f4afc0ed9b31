//! Validation of kept cells: some of their pixels are traced and compared with the interpolated values.
//!
//! Corners have no information about a shadow that passes between them, and no constant predicts how often
//! that happens in an unknown scene. A few pixels are therefore traced, chosen at random with a probability
//! proportional to their estimated effect on the error. Their mean squared error in each class of cells gives
//! the error of the whole image, the cells to split for the error target, and the remaining error.

use halflight_core::fragment::Fragments;
use halflight_core::hash;
use halflight_core::mask::Purpose;
use halflight_core::stages::Visibility;
use rayon::prelude::*;

use super::error_estimate::{Measured, rough_irradiance_of};
use super::{Lattice, NONE, Square, Verdict, View};
use crate::corners::Corners;
use crate::refine::representative::cell_rect;
use crate::refine::target::{NOISE_SHARE, Neighbours};
use crate::tangent_plane::Between;

/// Number of levels with classes of their own: 1, 2, 3 and coarser.
const LEVELS: usize = 4;

/// Number of classes of cells with similar errors: by level, by the presence of a depth discontinuity, and by
/// agreement of the corners.
const CLASSES: usize = 4 * LEVELS;

/// Number of validated pixels: one per `SHARE` samples, between `LEAST` and `MOST`.
const SHARE: usize = 24;
const LEAST: usize = 192;
const MOST: usize = 1536;

/// Fewest validated pixels of a class, if it has as many cells and its error is relevant.
const OF_A_CLASS: usize = 24;

/// Weight of the assumed mean error of a class, in validated pixels.
const ASSUMED: f64 = 6.0;

/// Fraction of the target, or of the noise where that is larger, that is left to interpolation at least:
/// where no number of samples reaches the target, finer cells do not either.
const LEAST_SHARE: f64 = 0.25;

/// Estimated error, relative to the target, from which cells are split (`TOLERATED`), and fraction of the
/// interpolation's share to which they are then reduced (`MARGIN`). The estimates are accurate to a factor of
/// about 1.5, and a target that is narrowly missed costs more to refine than it is worth.
const TOLERATED: f64 = 1.25;

/// Noise, relative to the planned noise, from which more samples are taken. Receivers in the penumbra are
/// then traced again, which costs as much as the first time.
const NOISY: f64 = 1.3;

const MARGIN: f64 = 0.8;

/// Unshadowed irradiance from which a pixel of a cell across a depth discontinuity is traced: relative to
/// that at the cell's corners (`BRIGHTER`), and relative to the image's root mean square (`BRIGHT`).
const BRIGHTER: f32 = 2.0;
const BRIGHT: f32 = 0.5;

/// Fraction of the error target that one wrong pixel may use up before it is traced.
const ONE_PIXEL: f32 = 0.2;

/// Coarsest level of kept cells across depth discontinuities.
const STEP_LEVEL: usize = 2;

/// Number of cells whose error estimates are summed together.
const TOGETHER: usize = 1024;

/// Most rounds of validation.
pub(super) const ROUNDS: u32 = 3;

/// Class and weight of a cell. The weight times the mean error of the class is the squared error of the
/// irradiance, per radiance, summed over the cell's pixels.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Weighed {
    class: u8,
    weight: f32,
    /// Number of pixels.
    pixels: f32,
    /// Square of the irradiance per radiance, summed over the pixels.
    energy: f32,
}

/// Pixel of a cell that is traced for validation.
#[derive(Clone, Copy, Debug)]
pub(super) struct Probe {
    /// Index of the cell in `kept`.
    index: u32,
    x: u32,
    y: u32,
}

/// Error statistics from validation.
#[derive(Clone, Copy, Debug)]
pub(super) struct Risk {
    /// Mean squared errors of the visible fraction, per unit of weight.
    means: [f64; CLASSES],
    /// Squared error per pixel, per radiance, above which cells are split.
    limit: f64,
}

impl Risk {
    /// Estimated squared error of the irradiance, per radiance, summed over a cell's pixels.
    fn error(&self, cell: &Weighed) -> f64 {
        self.means[usize::from(cell.class)] * f64::from(cell.weight)
    }
}

impl Default for Risk {
    fn default() -> Self {
        Self { means: std::array::from_fn(assumed), limit: f64::INFINITY }
    }
}

/// Prior mean error of a class: measured on the bundled scenes.
fn assumed(class: usize) -> f64 {
    match class % 4 {
        // Corners that agree; corners that differ, relative to the squared difference.
        0 => 2e-5,
        1 => 0.06,
        // Across a depth discontinuity: corners that agree; corners that differ.
        2 => 5e-4,
        _ => 2e-3,
    }
}

impl Lattice {
    /// Class and weight of a kept cell; the weight is 0 where no error is possible.
    pub(super) fn weigh(&self, view: &View, cell: Square) -> Weighed {
        let corners = cell.corners(view.gbuffer);
        let strongest = self.strongest(&corners);
        let (low, high) = super::split_test::range(&corners.pixels().map(|pixel| self.fraction(pixel)));
        let rect = cell_rect(view.gbuffer, cell.level, cell.x, cell.y);
        let pixels = ((rect.x1 - rect.x0) * (rect.y1 - rect.y0)) as f32;
        let step = self.discontinuities.inside(cell.level, cell.x, cell.y) == Between::Step;
        // Steep cells were kept because their parents predicted them to within the tolerance.
        let difference = (high - low).clamp(0.0, self.plan.tolerance(strongest));
        let mixed = difference > 0.0;
        let level = usize::from(cell.level).clamp(1, LEVELS) - 1;
        let class = 4 * level + 2 * usize::from(step) + usize::from(mixed);
        let scale = if mixed && !step { difference * difference } else { 1.0 };
        let weight = strongest * strongest * pixels * scale;
        Weighed { class: class as u8, weight, pixels, energy: pixels * self.brightness(&corners) }
    }

    /// Mean square of the irradiance per radiance at a cell's corners.
    fn brightness(&self, corners: &Corners) -> f32 {
        let square = |pixel: usize| match self.corners[pixel] {
            NONE => 0.0,
            sample => (self.fractions[sample as usize].max(0.0) * self.unshadowed[sample as usize]).powi(2),
        };
        corners.pixels().map(square).into_iter().sum::<f32>() / 4.0
    }

    /// True if the estimated error of a cell that passed the split test is within the limit found by
    /// validation.
    pub(super) fn fits_target(&self, view: &View, cell: Square) -> bool {
        let within = self.risk.limit == f64::INFINITY || {
            let weighed = self.weigh(view, cell);
            self.risk.error(&weighed) <= self.risk.limit * f64::from(weighed.pixels)
        };
        within && !self.outshines(view, cell)
    }

    /// True if a cell across a depth discontinuity has a pixel with so much unshadowed irradiance that it
    /// must be traced. One case is much more light than at the corners: corners that face away from the
    /// light, or hardly towards it, have no information about such a pixel. The other is so much light that a
    /// few wrong pixels would use up the error target, as in small images.
    fn outshines(&self, view: &View, cell: Square) -> bool {
        if !self.config.validate
            || self.plan.energy <= 0.0
            || self.discontinuities.inside(cell.level, cell.x, cell.y) != Between::Step
        {
            return false;
        }
        let strongest = self.strongest(&cell.corners(view.gbuffer));
        let mean = self.plan.energy.sqrt() as f32;
        let room = ONE_PIXEL * self.config.target * self.receivers as f32;
        let most = (BRIGHTER * strongest).max(BRIGHT * mean).min(room.sqrt() * mean);
        let rect = cell_rect(view.gbuffer, cell.level, cell.x, cell.y);
        let row = |y| (rect.x0..rect.x1).map(move |x| view.gbuffer.index(x, y) as u32);
        let mut unshadowed = [0.0; 1 << (2 * STEP_LEVEL)];
        rough_irradiance_of(
            view.frame.light(view.light),
            view.gbuffer,
            (rect.y0..rect.y1).flat_map(row),
            &mut unshadowed,
        );
        unshadowed.iter().any(|&unshadowed| unshadowed > most)
    }

    /// Estimated squared error of the irradiance per radiance, summed over all kept cells.
    pub(super) fn error_of_cells(&self, view: &View) -> f64 {
        let error = |kept: &Option<(Square, Verdict)>| self.risk.error(&self.weigh_kept(view, kept));
        let blocks = self.kept.par_chunks(TOGETHER).map(|block| block.iter().map(error).sum::<f64>());
        // Summation in a fixed order, for any number of threads.
        blocks.collect::<Vec<f64>>().iter().sum()
    }

    /// Class and weight of a kept cell; a cell that has a certificate, or was split later, has no weight.
    fn weigh_kept(&self, view: &View, kept: &Option<(Square, Verdict)>) -> Weighed {
        match *kept {
            Some((cell, Verdict::Keep)) => self.weigh(view, cell),
            _ => Weighed::default(),
        }
    }

    /// Validates the kept cells and splits those whose errors exceed the error target. Returns true if so
    /// many were split that the others should be validated once more.
    pub(super) fn validate(
        &mut self,
        round: u32,
        view: &View,
        visibility: &mut dyn Visibility,
        fragments: &mut Fragments,
    ) -> bool {
        let mut weighed = std::mem::take(&mut self.weighed);
        let weigh = |kept| self.weigh_kept(view, kept);
        self.kept.par_iter().with_min_len(256).map(weigh).collect_into_vec(&mut weighed);
        let interpolated: f64 = weighed.iter().map(|one| f64::from(one.energy)).sum();
        let Measured { noise, energy, noisy } = if round == 0 {
            self.raise(NOISE_SHARE, interpolated, view, visibility, fragments)
        } else {
            self.measure(view, fragments)
        };
        let whole = f64::from(self.config.target) * (energy + interpolated);
        let room = (whole - noise).max(LEAST_SHARE * whole.max(noise));
        self.probe(round, &weighed, [room, noise], view);
        for probe in &self.probes {
            let pixel = view.gbuffer.index(probe.x, probe.y);
            if view.gbuffer.is_receiver(pixel) && self.corners[pixel] == NONE {
                self.wanted.insert(probe.x, probe.y);
            }
        }
        let first = fragments.samples().len() as u32;
        self.request(view, 0, visibility, fragments);
        let mut off = std::mem::take(&mut self.off);
        off.clear();
        self.compare_probes(&weighed, view, fragments, first, &mut off);
        let error: f64 = weighed.iter().map(|one| self.risk.error(one)).sum();
        self.risk.limit = f64::INFINITY;
        if noise + error > TOLERATED * whole {
            // Traced pixels have noise: splitting cells whose error is smaller does not reduce the total.
            let limit = self.limit(&weighed, MARGIN * room);
            self.risk.limit = limit.max(noise / noisy.max(1.0));
            off.extend(
                self.ranked.iter().filter(|(density, _)| *density > self.risk.limit).map(|&(_, index)| index),
            );
            off.sort_unstable();
        }
        for &index in &off {
            if let Some((cell, _)) = self.kept[index as usize].take() {
                self.split(cell);
            }
        }
        (self.weighed, self.off) = (weighed, off);
        self.risk.limit < f64::INFINITY
    }

    /// Traces more samples of the receivers that see part of the light if the noise is larger than the pilot
    /// samples predicted; as many as are needed to reduce it to `share` of the target. `interpolated` is the
    /// energy of interpolated pixels. Returns the sums over the traced pixels afterwards.
    pub(super) fn raise(
        &mut self,
        share: f64,
        interpolated: f64,
        view: &View,
        visibility: &mut dyn Visibility,
        fragments: &mut Fragments,
    ) -> Measured {
        let found = self.measure(view, fragments);
        let goal = share * f64::from(self.config.target) * (found.energy + interpolated);
        let Some(raised) = self.plan.raised(found.noise, goal).filter(|_| found.noise > NOISY * goal) else {
            return found;
        };
        self.plan = raised;
        self.evaluate_fractions(view, self.fractions.len(), fragments);
        self.top_up(view, 0, Purpose::Final, visibility, fragments);
        self.measure(view, fragments)
    }

    /// Squared error per pixel of the last cell that fits into `room` when cells are taken in order of
    /// increasing error; infinity if all fit.
    fn limit(&mut self, weighed: &[Weighed], room: f64) -> f64 {
        let dense = |one: &Weighed| self.risk.error(one) / f64::from(one.pixels);
        self.ranked.clear();
        let some = (0..).zip(weighed).filter(|(_, one)| one.weight > 0.0);
        self.ranked.extend(some.map(|(index, one)| (dense(one), index)));
        self.ranked.par_sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut sum = 0.0;
        let last = self.ranked.iter().find(|&&(density, index)| {
            sum += density * f64::from(weighed[index as usize].pixels);
            sum > room
        });
        last.map_or(f64::INFINITY, |&(density, _)| density)
    }

    /// Chooses pixels to validate, in each class with a probability proportional to the cells' weights.
    fn probe(&mut self, round: u32, weighed: &[Weighed], [room, noise]: [f64; 2], view: &View) {
        let (mut weights, mut counts) = ([0.0f64; CLASSES], [0usize; CLASSES]);
        for one in weighed.iter().filter(|one| one.weight > 0.0) {
            weights[usize::from(one.class)] += f64::from(one.weight);
            counts[usize::from(one.class)] += 1;
        }
        let total = (self.fractions.len() / SHARE).clamp(LEAST, MOST) as f64;
        let errors: [f64; CLASSES] = std::array::from_fn(|class| weights[class] * self.risk.means[class]);
        let all: f64 = errors.iter().sum();
        self.probes.clear();
        let mut steps = [f64::INFINITY; CLASSES];
        let seen = (0.01 * room).min(0.05 * (all + noise));
        for class in 0..CLASSES {
            // Classes whose error would be irrelevant even if it were ten times as large are not validated.
            if errors[class] > seen {
                let count = (total * errors[class] / all).max(OF_A_CLASS.min(counts[class]) as f64);
                steps[class] = weights[class] / count;
            }
        }
        let mut next: [f64; CLASSES] = std::array::from_fn(|class| {
            steps[class] * f64::from(hash::unit_pair(hash::fold(hash::mix(round), class as u32)).0)
        });
        for (index, one) in (0..).zip(weighed) {
            let class = usize::from(one.class);
            next[class] -= f64::from(one.weight);
            while next[class] < 0.0 && one.weight > 0.0 {
                next[class] += steps[class];
                let Some((cell, _)) = self.kept[index as usize] else { break };
                let rect = cell_rect(view.gbuffer, cell.level, cell.x, cell.y);
                let (u, v) = hash::unit_pair(hash::fold(
                    hash::fold(hash::mix(round), index),
                    self.probes.len() as u32,
                ));
                let x = rect.x0 + (u * (rect.x1 - rect.x0) as f32) as u32;
                let y = rect.y0 + (v * (rect.y1 - rect.y0) as f32) as u32;
                self.probes.push(Probe { index, x, y });
            }
        }
    }

    /// Compares validated pixels with the interpolated values and updates the classes' mean errors. Appends
    /// to `off` the indices of cells whose error exceeds their tolerance. Samples from `first` on are new.
    fn compare_probes(
        &mut self,
        weighed: &[Weighed],
        view: &View,
        fragments: &Fragments,
        first: u32,
        off: &mut Vec<u32>,
    ) {
        let (mut sums, mut counts) = ([0.0f64; CLASSES], [0.0f64; CLASSES]);
        let mut neighbours = std::mem::take(&mut self.neighbours);
        neighbours.clear();
        neighbours.extend(
            fragments
                .batches()
                .iter()
                .map(|batch| Neighbours::of(batch.pattern(), view.frame.light(view.light))),
        );
        for &Probe { index, x, y } in &self.probes {
            let Some((cell, _)) = self.kept[index as usize] else { continue };
            let one = weighed[index as usize];
            let class = usize::from(one.class);
            counts[class] += 1.0;
            let sample = self.corners[view.gbuffer.index(x, y)];
            // Corners have no interpolation error, and background pixels contribute none.
            if sample == NONE || sample < first {
                continue;
            }
            let corners = cell.corners(view.gbuffer);
            let known = corners.pixels().map(|pixel| self.fraction(pixel));
            let (low, high) = super::split_test::range(&known);
            let expected = corners.interpolate(&view.planes, &known, x, y);
            let expected = if expected.is_nan() { 0.5 * (low + high) } else { expected.clamp(low, high) };
            let (found, strength) = (self.fractions[sample as usize], self.unshadowed[sample as usize]);
            if found.is_nan() || expected.is_nan() || strength <= 0.0 {
                continue;
            }
            let own = &fragments.samples()[sample as usize];
            let batch = fragments.batch(own.batch);
            let strata = self.strata.of(batch.pattern());
            let variance = neighbours[usize::from(own.batch)].variance(batch, own.first as usize, strata).0;
            let error = f64::from(found - expected).powi(2) - f64::from(variance);
            sums[class] +=
                error * f64::from(strength).powi(2) * f64::from(one.pixels) / f64::from(one.weight);
            if (found - expected).abs() > self.plan.tolerance(strength).max(3.0 * variance.sqrt()) {
                off.push(index);
            }
        }
        for class in 0..CLASSES {
            let mean = (sums[class] + ASSUMED * self.risk.means[class]) / (counts[class] + ASSUMED);
            self.risk.means[class] = mean.max(0.05 * assumed(class));
        }
        self.neighbours = neighbours;
    }
}
