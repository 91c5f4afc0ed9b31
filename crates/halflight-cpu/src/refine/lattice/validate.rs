//! Validation of kept cells: some of their pixels are traced and compared with what is interpolated there.
//!
//! Corners say nothing about a shadow that passes between them, and no constant about how often that happens in a scene that
//! nobody has seen. So a few pixels, chosen at random with a probability that follows from how much they matter, are asked
//! what they see. Their mean squared error, class by class of cells, tells what the image as a whole is off by, which of the
//! cells are to be split for the error target, and what error is left.

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

/// Levels that are told apart: 1, 2, 3 and coarser.
const LEVELS: usize = 4;

/// Classes of cells that err alike: by level, by whether a surface discontinuity passes through, and by whether all corners
/// agree.
const CLASSES: usize = 4 * LEVELS;

/// Validated pixels as a share of all samples, and their least and greatest number.
const SHARE: usize = 24;
const LEAST: usize = 192;
const MOST: usize = 1536;

/// Validated pixels of a class at least, where its cells are as many and can matter.
const OF_A_CLASS: usize = 24;

/// Validated pixels that the mean errors assumed beforehand count for.
const ASSUMED: f64 = 6.0;

/// Share of the target, or of the noise where that is more, that is left to interpolation at least: where no number of samples
/// reaches the target, finer cells do not either.
const LEAST_SHARE: f64 = 0.25;

/// Share of the target that may be expected before cells are split for it, and the share of what is left to interpolation
/// that they are then split down to: errors are known to within a factor of 1.5 or so, and what is just missed costs more to
/// refine than it is worth.
const TOLERATED: f64 = 1.25;

/// How many times the noise that was planned may be before more samples are taken: receivers in the penumbra are then asked
/// anew, which costs as much as they did.
const NOISY: f64 = 1.3;

const MARGIN: f64 = 0.8;

/// A pixel of a cell across a step is traced where it gets more than so many times the light of the cell's corners, and more
/// than so much of the image's root mean square.
const BRIGHTER: f32 = 2.0;
const BRIGHT: f32 = 0.5;

/// And where one wrong pixel would take so large a share of what the target leaves room for.
const ONE_PIXEL: f32 = 0.2;

/// The coarsest level of cells across steps.
const STEP_LEVEL: usize = 2;

/// Cells whose expected errors are added up together.
const TOGETHER: usize = 1024;

/// Times that cells are validated at most.
pub(super) const ROUNDS: u32 = 3;

/// A cell's class and weight: weights times the mean error of their class are squared errors of the irradiance, per radiance,
/// summed over the cell's pixels.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Weighed {
    class: u8,
    weight: f32,
    /// Pixels.
    pixels: f32,
    /// Square of the irradiance per radiance, summed over the pixels.
    energy: f32,
}

/// A pixel of a cell that is asked for validation.
#[derive(Clone, Copy, Debug)]
pub(super) struct Probe {
    /// Place of the cell among those kept.
    place: u32,
    x: u32,
    y: u32,
}

/// What validation has found.
#[derive(Clone, Copy, Debug)]
pub(super) struct Risk {
    /// Mean squared errors of the visible fraction, per unit of weight.
    means: [f64; CLASSES],
    /// Squared error a pixel, per radiance, above which cells are split.
    limit: f64,
}

impl Risk {
    /// Squared error of the irradiance, per radiance, that is expected of a cell's pixels together.
    fn error(&self, cell: &Weighed) -> f64 {
        self.means[usize::from(cell.class)] * f64::from(cell.weight)
    }
}

impl Default for Risk {
    fn default() -> Self {
        Self { means: std::array::from_fn(assumed), limit: f64::INFINITY }
    }
}

/// Mean error of a class before anything is known: measured on the bundled scenes.
fn assumed(class: usize) -> f64 {
    match class % 4 {
        // Between corners that agree, and between corners that do not: of the square of their difference.
        0 => 2e-5,
        1 => 0.06,
        // Across a discontinuity likewise.
        2 => 5e-4,
        _ => 2e-3,
    }
}

impl Lattice {
    /// Weighs a kept cell; a weight of 0 where nothing can be wrong.
    pub(super) fn weigh(&self, view: &View, cell: Square) -> Weighed {
        let corners = cell.corners(view.gbuffer);
        let strongest = self.strongest(&corners);
        let (low, high) = super::split_test::range(&corners.pixels().map(|pixel| self.fraction(pixel)));
        let rect = cell_rect(view.gbuffer, cell.level, cell.x, cell.y);
        let pixels = ((rect.x1 - rect.x0) * (rect.y1 - rect.y0)) as f32;
        let step = self.discontinuities.inside(cell.level, cell.x, cell.y) == Between::Step;
        // Steep cells were kept since their parents had predicted them to within the tolerance.
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

    /// Whether a cell whose corners agree well enough may be kept by what validation has found.
    pub(super) fn fits_target(&self, view: &View, cell: Square) -> bool {
        let within = self.risk.limit == f64::INFINITY || {
            let weighed = self.weigh(view, cell);
            self.risk.error(&weighed) <= self.risk.limit * f64::from(weighed.pixels)
        };
        within && !self.outshines(view, cell)
    }

    /// Whether a pixel of a cell across a step gets so much light, unless it is shadowed, that it is traced: much more than the
    /// cell's corners, since corners that face away from the light, or hardly towards it, say nothing about it; or so much
    /// that a few wrong pixels like it are all that the target leaves room for, as in small images.
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

    /// Squared error of the irradiance per radiance that is expected of all kept cells.
    pub(super) fn error_of_cells(&self, view: &View) -> f64 {
        let error = |kept: &Option<(Square, Verdict)>| self.risk.error(&self.weigh_kept(view, kept));
        let blocks = self.kept.par_chunks(TOGETHER).map(|block| block.iter().map(error).sum::<f64>());
        // In one order, whatever the number of threads.
        blocks.collect::<Vec<f64>>().iter().sum()
    }

    /// Weighs a kept cell; one that is proved, or was split later, has no weight.
    fn weigh_kept(&self, view: &View, kept: &Option<(Square, Verdict)>) -> Weighed {
        match *kept {
            Some((cell, Verdict::Keep)) => self.weigh(view, cell),
            _ => Weighed::default(),
        }
    }

    /// Validates the kept cells and splits those that the error target has no room for. Returns whether these
    /// are so many that the others should be validated once more.
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
            // Pixels of their own have noise: more of them are no better than cells that err less than they do.
            let limit = self.limit(&weighed, MARGIN * room);
            self.risk.limit = limit.max(noise / noisy.max(1.0));
            off.extend(
                self.ranked.iter().filter(|(density, _)| *density > self.risk.limit).map(|&(_, place)| place),
            );
            off.sort_unstable();
        }
        for &place in &off {
            if let Some((cell, _)) = self.kept[place as usize].take() {
                self.split(cell);
            }
        }
        (self.weighed, self.off) = (weighed, off);
        self.risk.limit < f64::INFINITY
    }

    /// Takes more samples of the receivers that see part of the light where their noise is more than the pilot samples had predicted, so
    /// many that no more than a share of the target is left. `interpolated` is the energy of interpolated pixels. Returns what
    /// the others show then.
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

    /// Squared error a pixel of the last cell that there is room for when those come first that err least; infinity where
    /// there is room for all.
    fn limit(&mut self, weighed: &[Weighed], room: f64) -> f64 {
        let dense = |one: &Weighed| self.risk.error(one) / f64::from(one.pixels);
        self.ranked.clear();
        let some = (0..).zip(weighed).filter(|(_, one)| one.weight > 0.0);
        self.ranked.extend(some.map(|(place, one)| (dense(one), place)));
        self.ranked.par_sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut sum = 0.0;
        let last = self.ranked.iter().find(|&&(density, place)| {
            sum += density * f64::from(weighed[place as usize].pixels);
            sum > room
        });
        last.map_or(f64::INFINITY, |&(density, _)| density)
    }

    /// Chooses pixels to validate: of every class in proportion to weight.
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
            // What could not matter if it were ten times as wrong is not looked at.
            if errors[class] > seen {
                let count = (total * errors[class] / all).max(OF_A_CLASS.min(counts[class]) as f64);
                steps[class] = weights[class] / count;
            }
        }
        let mut next: [f64; CLASSES] = std::array::from_fn(|class| {
            steps[class] * f64::from(hash::unit_pair(hash::fold(hash::mix(round), class as u32)).0)
        });
        for (place, one) in (0..).zip(weighed) {
            let class = usize::from(one.class);
            next[class] -= f64::from(one.weight);
            while next[class] < 0.0 && one.weight > 0.0 {
                next[class] += steps[class];
                let Some((cell, _)) = self.kept[place as usize] else { break };
                let rect = cell_rect(view.gbuffer, cell.level, cell.x, cell.y);
                let (u, v) = hash::unit_pair(hash::fold(
                    hash::fold(hash::mix(round), place),
                    self.probes.len() as u32,
                ));
                let x = rect.x0 + (u * (rect.x1 - rect.x0) as f32) as u32;
                let y = rect.y0 + (v * (rect.y1 - rect.y0) as f32) as u32;
                self.probes.push(Probe { place, x, y });
            }
        }
    }

    /// Compares validated pixels with what is interpolated there; appends the places of cells that are off by more than their
    /// tolerance to `off`. Samples from `first` on are new.
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
        neighbours.extend(fragments.batches().iter().map(|batch| Neighbours::new(batch.pattern())));
        for &Probe { place, x, y } in &self.probes {
            let Some((cell, _)) = self.kept[place as usize] else { continue };
            let one = weighed[place as usize];
            let class = usize::from(one.class);
            counts[class] += 1.0;
            let sample = self.corners[view.gbuffer.index(x, y)];
            // Corners are what they are, and what sees nothing adds nothing.
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
            let variance = neighbours[usize::from(own.batch)].variance(batch, own.first as usize).0;
            let error = f64::from(found - expected).powi(2) - f64::from(variance);
            sums[class] +=
                error * f64::from(strength).powi(2) * f64::from(one.pixels) / f64::from(one.weight);
            if (found - expected).abs() > self.plan.tolerance(strength).max(3.0 * variance.sqrt()) {
                off.push(place);
            }
        }
        for class in 0..CLASSES {
            let mean = (sums[class] + ASSUMED * self.risk.means[class]) / (counts[class] + ASSUMED);
            self.risk.means[class] = mean.max(0.05 * assumed(class));
        }
        self.neighbours = neighbours;
    }
}
