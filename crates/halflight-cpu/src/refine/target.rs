//! Sampling plan for an error target: number of light samples and interpolation tolerance, from pilot samples
//! of the frame.

use glam::DVec3;
use halflight_core::light::{AreaLight, Extent};
use halflight_core::mask::MaskBatch;
use halflight_core::pattern::{Pattern, PatternKind};

use crate::textured::StrataRadiance;

/// Estimated squared error of a stratified estimate, over the number of differing neighbouring samples and
/// the inverse square of the number of samples. An edge along the strata cuts one in each row, whose sample
/// is wrong by p(1 − p) in the mean square, a sixth over all p; an oblique one cuts more, but many of them
/// near a corner.
const NOISE: f64 = 0.12;

/// Relative growth of [`NOISE`] where all samples of the rarer kind are isolated: the occluders are thinner
/// than a stratum. The number of such samples is then its own expected squared error, with four differing
/// neighbours each.
const ALONE: f64 = 1.1;

/// Fraction of differing neighbours from which on samples are practically independent: foliage. The error is
/// then inversely proportional to the number of samples, and not to its power of 1.5 as at an edge.
const INDEPENDENT: f64 = 0.35;

/// Mean squared error of interpolated pixels, over the square of the interpolation tolerance and the image's
/// mean square. Measured on the bundled scenes, from 1e-3 to 4e-3.
const INTERPOLATION: f64 = 2e-3;

/// Largest interpolation tolerance.
const MOST_ERROR: f32 = 0.3;

/// Smallest interpolation tolerance.
const LEAST_ERROR: f64 = 0.01;

/// Standard deviation of the visible fraction in the middle of a penumbra with the pilot samples
/// (`DEVIATION`), the power of the number of samples with which it falls (`DECAY`), and the least
/// interpolation tolerance in standard deviations (`DEVIATIONS`).
const DEVIATION: f64 = 0.02;
const DECAY: f64 = 0.75;
const DEVIATIONS: f64 = 2.5;

/// Floor of the local brightness, relative to the root mean square of the irradiance: about a fiftieth of the brightest pixels.
const FLOOR: f32 = 0.06;

/// Fraction of the error target that is left to noise.
pub(super) const NOISE_SHARE: f64 = 0.6;

/// Range of the number of samples along one side of the light. Fewer than 16 samples miss too much; more than
/// 1,024 have no visible effect.
const SIDES: std::ops::RangeInclusive<u16> = LEAST_SIDE..=32;
const LEAST_SIDE: u16 = 4;

/// Pilot samples along one side. Every receiver gets as many if more than [`ONCE`] are needed; then only
/// receivers in the penumbra get all samples.
const FIRST: u16 = 8;

/// Most samples along one side that every receiver gets at once. Fully lit receivers and those in umbra cost
/// little, by packets as by beams, and a second batch costs more. Nor is anything missed between a few first
/// samples.
const ONCE: u16 = 20;

/// Division of an error target between noise and interpolation, independent of the number of light samples.
/// CPU and GPU derive their sampling plans from it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Budget {
    /// Noise of the masks, NMSE₂.
    pub noise: f64,
    /// Interpolation tolerance before the bounds by noise and constants are applied.
    pub interpolation: f64,
}

/// Treatment of depth discontinuities: coarsest cells kept across them, and convex edges that count as such.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Steps {
    /// Coarsest level of cells that are kept across a depth discontinuity.
    pub level: u8,
    /// Cosine of the angle between normals from which convex edges count as discontinuities; below -1 for
    /// none. Where parts meet at an edge there are grooves finer than a pixel that shadow single pixels;
    /// small targets leave no room for these errors.
    pub edge: f32,
}

impl Steps {
    /// Settings for an error target, or for a fixed interpolation tolerance where it is 0.
    pub fn new(target: f32) -> Self {
        let level = STEPS.iter().filter(|&&above| target <= 0.0 || target > above).count() as u8;
        Self { level, edge: if level > 0 { -2.0 } else { EDGE } }
    }
}

/// Cells of up to 4 × 4 pixels: thin objects have no corner in larger ones.
impl Default for Steps {
    fn default() -> Self {
        Self::new(0.0)
    }
}

impl Budget {
    /// Pilot samples along one side of the light.
    pub const PILOT: u16 = FIRST;

    /// Share of a bound on visible errors for [`Budget::least_side`] on devices that ask receivers with visible noise again.
    pub const NOISY: f64 = 0.5;

    /// Share for devices that ask every receiver once.
    pub const ONLY: f64 = 1.0 / 3.0;

    /// Most samples along one side of the light that every receiver gets at once.
    pub const ONCE: u16 = ONCE;

    /// Fraction of the receivers in pending cells of a level, from 0 on, from which on all pixels are traced:
    /// the finer levels and their bookkeeping cost more than they save, and geometry fine enough to break up
    /// so much of the image is missed between corners as well. At the finer of the two levels, some four
    /// fifths of the pixels get masks in the end. Chosen on atrium, nave, toys, church, tower and tree at 640
    /// × 480: the church has 0.59 and 0.84 or more, the others up to 0.50 and 0.72.
    pub const DENSE: [Option<f32>; 3] = [None, Some(0.54), Some(0.77)];

    /// Divides an error target, NMSE₂.
    pub fn new(target: f32) -> Self {
        let target = f64::from(target);
        Self {
            noise: NOISE_SHARE * target,
            interpolation: ((1.0 - NOISE_SHARE) * target / INTERPOLATION).sqrt(),
        }
    }

    /// Fewest samples along one side of the light with a bound on visible errors: the noise in the middle of a penumbra, before smoothing, is
    /// at most `share` of the bound. It is [`Budget::NOISY`] where receivers with visible noise are asked again, else [`Budget::ONLY`].
    pub fn least_side(visible_error: f32, share: f64) -> u16 {
        if visible_error <= 0.0 {
            return LEAST_SIDE;
        }
        let side = f64::from(FIRST) * (DEVIATION / (share * f64::from(visible_error))).powf(0.5 / DECAY);
        (side.ceil() as u16).clamp(LEAST_SIDE, ONCE)
    }

    /// Interpolation tolerance with `side` samples along a side of the light.
    pub fn error(&self, side: u16) -> f32 {
        (self.interpolation as f32).clamp(Self::least(side), MOST_ERROR)
    }

    /// Least interpolation tolerance: below the masks' own noise, pixels are no better than the values they
    /// replace.
    pub fn least(side: u16) -> f32 {
        let deviation = DEVIATION * (f64::from(FIRST * FIRST) / f64::from(side * side)).powf(DECAY);
        (DEVIATIONS * deviation).clamp(LEAST_ERROR, f64::from(MOST_ERROR)) as f32
    }
}

/// Sampling plan for an error target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SamplingPlan {
    /// Pattern for every receiver.
    pub(super) first: Pattern,
    /// Pattern for receivers that see part of the light.
    pub(super) full: Pattern,
    /// Interpolation tolerance where the light has mean strength.
    pub(super) error: f32,
    /// Least interpolation tolerance: below, pixels are no better than the values they replace.
    least: f32,
    /// Pattern for every receiver if nothing is interpolated.
    every: Pattern,
    /// Mean square of the irradiance per radiance; 0 for the same tolerance everywhere.
    pub(super) energy: f64,
    /// Pattern for receivers whose noise would be visible; `full` without a bound on it.
    pub(super) fine: Pattern,
    /// Root mean square of the irradiance per radiance.
    rms: f32,
}

/// Error targets above which cells of level 1 and 2 are kept across depth discontinuities: three times the
/// NMSE₂ of shadows that such cells miss between their corners, measured on the halls. Coarser ones are never
/// kept.
const STEPS: [f32; 2] = [3e-5, 9e-5];

/// Cosine of the angle between normals at a convex edge: 37°. Round objects turn less from pixel to pixel.
const EDGE: f32 = 0.8;

/// Initial plan, until a frame sets one.
impl Default for SamplingPlan {
    fn default() -> Self {
        Self::pilot(PatternKind::Jittered, 0.05)
    }
}

impl SamplingPlan {
    /// Plan with one pattern for all receivers.
    pub(super) fn fixed(pattern: Pattern, error: f32) -> Self {
        Self {
            first: pattern,
            full: pattern,
            error,
            least: error,
            every: pattern,
            energy: 0.0,
            fine: pattern,
            rms: 0.0,
        }
    }

    /// Plan of the pilot samples, from which the final plan is made.
    pub(super) fn pilot(kind: PatternKind, error: f32) -> Self {
        Self::fixed(square(kind, FIRST), error)
    }

    /// Plan that reaches an error target (NMSE₂), by the pilot samples of receivers that are evenly
    /// distributed over the image; with at least `least` samples along a side of the light.
    pub(super) fn reach(target: f32, least: u16, kind: PatternKind, pilot: &[PilotSample]) -> Self {
        let budget = Budget::new(target);
        let energy: f64 = pilot.iter().map(PilotSample::energy).sum();
        let noisy: Vec<&PilotSample> = pilot.iter().filter(|one| one.variance > 0.0).collect();
        let noise = |side: u16| noisy.iter().map(|one| one.noise_with(side)).sum::<f64>();
        // The noise decreases with the number of samples.
        let side_for = |error: f64| {
            let (mut low, mut high) = (*SIDES.start(), *SIDES.end());
            while low < high {
                let middle = low.midpoint(high);
                if noise(middle) <= error * energy { high = middle } else { low = middle + 1 }
            }
            low
        };
        let side = side_for(budget.noise).max(least);
        Self {
            first: square(kind, if side <= ONCE { side } else { FIRST }),
            full: square(kind, side),
            error: budget.error(side),
            least: Budget::least(side),
            every: square(kind, side_for(f64::from(target)).max(least)),
            energy: energy / pilot.len().max(1) as f64,
            fine: square(kind, side),
            rms: (energy / pilot.len().max(1) as f64).sqrt() as f32,
        }
    }

    /// Plan with enough samples for nine of ten receivers whose noise exceeds `most` of the local brightness. `sides` is memory that is
    /// kept.
    pub(super) fn with_visible_noise(self, most: f32, pilot: &[PilotSample], sides: &mut Vec<f32>) -> Self {
        let side_of = |one: &PilotSample| {
            let noise = one.variance.sqrt() / self.brightness(one.fraction, one.unshadowed);
            f32::from(FIRST) * (noise / most).powf(1.0 / 1.5)
        };
        sides.clear();
        sides.extend(pilot.iter().map(side_of).filter(|&side| side > f32::from(self.full.columns)));
        sides.sort_unstable_by(f32::total_cmp);
        let side = sides.get(sides.len() * 9 / 10).map_or(0, |side| side.ceil() as u16);
        let side = side.clamp(self.full.columns, *SIDES.end());
        Self { fine: square(self.full.kind, side), ..self }
    }

    /// Visible fraction that counts as the local brightness where errors are compared with it: a floor is added, since dark
    /// places are seen beside bright ones.
    #[inline]
    pub(super) fn brightness(&self, fraction: f32, unshadowed: f32) -> f32 {
        fraction + FLOOR * self.rms / unshadowed.max(f32::MIN_POSITIVE)
    }

    /// Plan with one tolerance, independent of the strength of the light.
    pub(super) fn alike_everywhere(&self) -> Self {
        Self { energy: 0.0, ..*self }
    }

    /// Interpolation tolerance at a given unshadowed irradiance per radiance: the error of the irradiance is
    /// the relevant one.
    #[inline]
    pub(super) fn tolerance(&self, unshadowed: f32) -> f32 {
        if self.energy <= 0.0 {
            return self.error;
        }
        let weaker = self.energy.sqrt() as f32 / unshadowed.max(f32::MIN_POSITIVE);
        (self.error * weaker).clamp(self.least, MOST_ERROR.max(self.least))
    }

    /// Fraction of [`Budget::DENSE`], where it applies.
    pub(super) fn dense_share(&self, level: u8) -> Option<f32> {
        // In foliage the number of receivers that see part of the light decides, and interpolation saves most
        // of them.
        if self.every.columns > ONCE {
            return None;
        }
        Budget::DENSE.get(usize::from(level)).copied().flatten()
    }

    /// Plan without interpolation. Receivers are traced twice only where that saves more than it costs.
    pub(super) fn every_pixel(&self) -> Self {
        let once = self.every.columns <= ONCE;
        Self {
            first: if once { self.every } else { square(self.every.kind, FIRST) },
            full: self.every,
            ..*self
        }
    }

    /// Plan with more samples for receivers that see part of the light, which reduces `noise` to `goal`; none
    /// if that takes more samples than possible.
    pub(super) fn raised(&self, noise: f64, goal: f64) -> Option<Self> {
        // Exponent between those of edges and of foliage.
        let sides = f64::from(self.full.columns) * (noise / goal).powf(0.4);
        let side = sides.ceil() as u16;
        let full = square(self.full.kind, side);
        (side > self.full.columns && SIDES.contains(&side)).then_some(Self { full, ..*self })
    }

    /// All patterns that a plan may have.
    pub(super) fn patterns(kind: PatternKind) -> Vec<Pattern> {
        SIDES.map(|side| square(kind, side)).collect()
    }
}

fn square(kind: PatternKind, side: u16) -> Pattern {
    Pattern { kind, columns: side, rows: side }
}

/// Result of the pilot samples of one receiver.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct PilotSample {
    /// Unshadowed irradiance per radiance.
    pub(super) unshadowed: f32,
    /// Visible fraction; NaN for none.
    pub(super) fraction: f32,
    /// Expected squared error of the fraction.
    pub(super) variance: f32,
    /// Fraction of differing neighbouring samples.
    pub(super) disagreement: f32,
}

impl PilotSample {
    fn energy(&self) -> f64 {
        f64::from(self.unshadowed * self.fraction.max(0.0)).powi(2)
    }

    /// Expected squared error with this many samples along a side.
    fn noise_with(&self, side: u16) -> f64 {
        let power = 1.5 - 0.5 * (f64::from(self.disagreement) / INDEPENDENT).min(1.0);
        let fewer = f64::from(FIRST * FIRST) / f64::from(side * side);
        f64::from(self.unshadowed).powi(2) * f64::from(self.variance) * fewer.powf(power)
    }
}

/// Neighbourhood of samples in a pattern.
#[derive(Clone, Copy, Debug)]
pub(super) struct Neighbours {
    columns: usize,
    /// Samples that have one to their right.
    inner: [u64; Pattern::MAX_LEN / 64],
    /// Samples that have one in the next row, for a light that is no parallelogram; otherwise none.
    upper: [u64; Pattern::MAX_LEN / 64],
}

impl Neighbours {
    pub(super) fn new(pattern: Pattern) -> Self {
        let columns = usize::from(pattern.columns).max(1);
        let mut inner = [0; Pattern::MAX_LEN / 64];
        for index in (0..pattern.len()).filter(|index| index % columns + 1 < columns) {
            inner[index / 64] |= 1 << (index % 64);
        }
        Self { columns, inner, upper: [0; Pattern::MAX_LEN / 64] }
    }

    /// Neighbourhood of samples of a light: with the rim of one that is no parallelogram.
    pub(super) fn of(pattern: Pattern, light: &AreaLight) -> Self {
        let mut neighbours = Self::new(pattern);
        if light.extent() != Extent::Whole {
            for index in 0..pattern.len().saturating_sub(neighbours.columns) {
                neighbours.upper[index / 64] |= 1 << (index % 64);
            }
        }
        neighbours
    }

    /// Number of samples beside the rim of the light that see it, and of those that do not, once for each neighbour beyond.
    fn rim(&self, wanted: &[u64], visible: &[u64]) -> (u32, u32) {
        let (mut lit, mut all) = (0, 0);
        for word in 0..wanted.len() {
            for (by, pairs) in [(1, self.inner[word]), (self.columns, self.upper[word])] {
                let next = later(wanted, word, by);
                let (before, behind) = (wanted[word] & !next & pairs, !wanted[word] & next & pairs);
                all += before.count_ones() + behind.count_ones();
                lit += (before & visible[word]).count_ones();
                lit += (behind & later(visible, word, by)).count_ones();
            }
        }
        (lit, all - lit)
    }

    /// Expected squared error of the visible fraction that a query's mask gives, and the fraction of
    /// differing neighbouring samples. With the strata of a textured light, errors are those of red, green and blue together.
    pub(super) fn variance(
        &self,
        batch: &MaskBatch,
        query: usize,
        strata: Option<&StrataRadiance>,
    ) -> (f32, f32) {
        let (wanted, visible) = (batch.wanted(query), batch.visible(query));
        let (mut lit, mut count) = (0, 0);
        for (&wanted, &visible) in wanted.iter().zip(visible) {
            lit += (wanted & visible).count_ones();
            count += wanted.count_ones();
        }
        if lit == 0 || lit == count {
            return (0.0, 0.0);
        }
        let rarer = f64::from(lit.min(count - lit));
        let (mut pairs, mut differ) = (0, 0);
        for word in 0..wanted.len() {
            let both = wanted[word] & later(wanted, word, 1) & self.inner[word];
            pairs += both.count_ones();
            differ += (both & (visible[word] ^ later(visible, word, 1))).count_ones();
            let both = wanted[word] & later(wanted, word, self.columns);
            pairs += both.count_ones();
            differ += (both & (visible[word] ^ later(visible, word, self.columns))).count_ones();
        }
        let (count, differ) = (f64::from(count), f64::from(differ));
        let alone = alone(differ, rarer);
        let weight = match strata {
            // A stratum across the rim has its sample inside by chance, which moves the fraction towards that sample.
            None if self.upper[0] != 0 => {
                let (inside, fraction) = (self.rim(wanted, visible), f64::from(lit) / count);
                let rim =
                    f64::from(inside.0) * (1.0 - fraction).powi(2) + f64::from(inside.1) * fraction.powi(2);
                (differ + rim) / (count * count)
            }
            None => differ / (count * count),
            Some(strata) => self.weight(wanted, visible, strata),
        };
        let variance = NOISE * (1.0 + ALONE * alone) * weight;
        (variance as f32, (differ / f64::from(pairs.max(1))) as f32)
    }
}

impl Neighbours {
    /// Number of differing neighbouring samples over the square of the number of samples, each by what its stratum emits. A stratum that differs
    /// from a neighbour is cut by an edge, and its error has the size of its mean square: part of it comes from the texture's variation inside.
    fn weight(&self, wanted: &[u64], visible: &[u64], strata: &StrataRadiance) -> f64 {
        let (mut sum, mut whole) = (0.0, DVec3::ZERO);
        let each = |mut bits: u64, word: usize, add: &mut dyn FnMut(usize)| {
            while bits != 0 {
                add(word * 64 + bits.trailing_zeros() as usize);
                bits &= bits - 1;
            }
        };
        for word in 0..wanted.len() {
            each(wanted[word], word, &mut |sample| whole += strata.rgb(sample).as_dvec3());
            for (by, inner) in [(1, self.inner[word]), (self.columns, u64::MAX)] {
                let both = wanted[word] & later(wanted, word, by) & inner;
                let apart = both & (visible[word] ^ later(visible, word, by));
                let square = |stratum| f64::from(strata.square(stratum));
                each(apart, word, &mut |sample| sum += 0.5 * (square(sample) + square(sample + by)));
            }
        }
        let whole = whole.length_squared();
        if whole > 0.0 { sum / whole } else { 0.0 }
    }
}

/// Fraction of the samples of the rarer kind that are isolated, 0 … 1, from the number of differing
/// neighbours: at most four of each sample, and one of each along the edges of larger groups.
fn alone(differ: f64, rarer: f64) -> f64 {
    ((differ / rarer - 1.0) / 3.0).clamp(0.0, 1.0)
}

/// Word of a mask shifted by `by` samples, up to 64.
fn later(words: &[u64], word: usize, by: usize) -> u64 {
    let next = words.get(word + 1).copied().unwrap_or(0);
    if by >= 64 { next } else { words[word] >> by | next << 1 << (63 - by) }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use halflight_core::mask::Purpose;

    use super::*;

    /// Mask of the samples left of a line, and the exact fraction of the light that lies there.
    fn edge(side: u16, key: u32, slope: f32, place: f32) -> (MaskBatch, f32) {
        let pattern = square(PatternKind::Jittered, side);
        let mut batch = MaskBatch::default();
        batch.reset(0, pattern, Purpose::Final);
        batch.push(Vec3::ZERO, Vec3::Y, 0, key, None);
        let parts = batch.parts();
        let mut seen = 0;
        for index in 0..pattern.len() {
            let at = pattern.position(index, key);
            if at.x + slope * (at.y - 0.5) < place {
                parts.visible[index / 64] |= 1 << (index % 64);
                seen += 1;
            }
        }
        (batch, seen as f32 / pattern.len() as f32)
    }

    #[test]
    fn the_noise_of_edges_is_predicted() {
        for side in [4, 8, 16] {
            for slope in [0.0, 0.4, 0.9] {
                let (mut expected, mut found) = (0.0, 0.0);
                for key in 0..4000u32 {
                    let place = 0.46 + 0.08 * (key as f32 / 4000.0);
                    let (batch, fraction) = edge(side, key * 77 + 1, slope, place);
                    expected += f64::from(Neighbours::new(batch.pattern()).variance(&batch, 0, None).0);
                    found += f64::from(fraction - place).powi(2);
                }
                let ratio = expected / found;
                assert!((0.5..2.0).contains(&ratio), "{side} {slope}: {ratio}");
            }
        }
        let (batch, _) = edge(8, 1, 0.0, 2.0);
        assert_eq!(Neighbours::new(batch.pattern()).variance(&batch, 0, None), (0.0, 0.0));
    }

    #[test]
    fn the_noise_of_what_is_thinner_than_a_stratum_is_predicted() {
        for side in [6, 8, 16] {
            let (mut expected, mut found) = (0.0, 0.0);
            for key in 0..4000u32 {
                let pattern = square(PatternKind::Jittered, side);
                let mut batch = MaskBatch::default();
                batch.reset(0, pattern, Purpose::Final);
                batch.push(Vec3::ZERO, Vec3::Y, 0, key, None);
                let (parts, mut seen) = (batch.parts(), 0);
                // Two oblique bars of a hundredth each.
                let (width, place) = (0.01, 0.2 + 0.5 * key as f32 / 4000.0);
                for index in 0..pattern.len() {
                    let at = pattern.position(index, key);
                    let bar = |from: f32| (from..from + width).contains(&(at.x + 0.1 * (at.y - 0.5)));
                    if !bar(place) && !bar(place + 0.2) {
                        parts.visible[index / 64] |= 1 << (index % 64);
                        seen += 1;
                    }
                }
                expected += f64::from(Neighbours::new(pattern).variance(&batch, 0, None).0);
                found += (f64::from(seen) / pattern.len() as f64 - 1.0 + 2.0 * f64::from(width)).powi(2);
            }
            let ratio = expected / found;
            assert!((0.6..1.6).contains(&ratio), "{side}: {ratio}");
        }
    }

    #[test]
    fn neighbours_are_those_of_the_pattern() {
        for (columns, rows) in [(8, 8), (7, 7), (5, 9), (64, 3), (1, 70), (16, 16), (31, 31)] {
            let pattern = Pattern { kind: PatternKind::Jittered, columns, rows };
            let mut batch = MaskBatch::default();
            batch.reset(0, pattern, Purpose::Final);
            batch.push(Vec3::ZERO, Vec3::Y, 0, 0, None);
            let seen = |index: usize| (index * 7919 % 13) < 6;
            let parts = batch.parts();
            for index in (0..pattern.len()).filter(|&index| seen(index)) {
                parts.visible[index / 64] |= 1 << (index % 64);
            }
            let columns = usize::from(columns);
            let (mut pairs, mut differ) = (0, 0);
            for index in 0..pattern.len() {
                let right = (index % columns + 1 < columns).then_some(index + 1);
                let below = (index + columns < pattern.len()).then_some(index + columns);
                for next in [right, below].into_iter().flatten() {
                    pairs += 1;
                    differ += i32::from(seen(index) != seen(next));
                }
            }
            let (variance, disagreement) = Neighbours::new(pattern).variance(&batch, 0, None);
            let count = pattern.len() as f64;
            assert_eq!(disagreement, (f64::from(differ) / f64::from(pairs)) as f32, "{pattern:?}");
            let lit = (0..pattern.len()).filter(|&index| seen(index)).count();
            let alone = alone(f64::from(differ), lit.min(pattern.len() - lit) as f64);
            let expected = NOISE * (1.0 + ALONE * alone) * f64::from(differ) / (count * count);
            assert_eq!(variance, expected as f32, "{pattern:?}");
        }
    }

    #[test]
    fn smaller_errors_take_more_samples_and_finer_cells() {
        let one = PilotSample { unshadowed: 1.0, fraction: 0.5, variance: 4e-4, disagreement: 0.07 };
        let lit = PilotSample { unshadowed: 1.0, fraction: 1.0, ..PilotSample::default() };
        let pilot: Vec<PilotSample> = [one; 10].into_iter().chain([lit; 90]).collect();
        let reach = |target| SamplingPlan::reach(target, LEAST_SIDE, PatternKind::Jittered, &pilot);
        // Noise is 10 · 4e-4 over an energy of 92.5: 4.3e-5 with 64 samples.
        let (coarse, fine, finest) = (reach(1e-3), reach(1e-4), reach(1e-6));
        assert!(coarse.full.len() < 64 && coarse.first == coarse.full);
        assert_eq!(fine.full.len(), 64);
        assert!(finest.full.len() > 256 && finest.first.len() == 64);
        assert!(coarse.error > fine.error && fine.error > finest.error);
        // Foliage needs more samples for the same target.
        let disagreement: Vec<PilotSample> =
            pilot.iter().map(|one| PilotSample { disagreement: 0.5, ..*one }).collect();
        assert!(
            SamplingPlan::reach(1e-5, LEAST_SIDE, PatternKind::Jittered, &disagreement).full.len()
                > reach(1e-5).full.len()
        );
        // Edges are discontinuities for targets that keep no cell across discontinuities.
        assert!([0.0, 1e-3, 1e-4, 4e-5].iter().all(|&target| Steps::new(target).edge < -1.0));
        assert_eq!([0.0, 1e-4, 4e-5, 2e-5].map(|target| Steps::new(target).level), [2, 2, 1, 0]);
        assert!([3e-5, 1e-5].iter().all(|&target| Steps::new(target) == Steps { level: 0, edge: EDGE }));
        // A dark image needs the fewest samples.
        assert_eq!(SamplingPlan::reach(1e-4, LEAST_SIDE, PatternKind::Jittered, &[]).full.len(), 16);
    }
}
