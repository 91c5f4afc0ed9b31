//! Sums over the light samples of a mask, weighted by what the samples' strata emit.

use glam::{Vec3, Vec4};
use halflight_core::light::AreaLight;
use halflight_core::light_texture::PlacedTexture;
use halflight_core::mask::MaskBatch;
use halflight_core::pattern::Pattern;

use crate::samples::{LANES, facing, geometry_terms, points};
use crate::simd::{Isa, Kernel, Lanes, Simd};
use crate::vector::Vector;

/// Mean radiance of a textured light in the strata of a pattern, relative to the light's radiance.
#[derive(Clone, Debug)]
pub struct StrataRadiance {
    pattern: Pattern,
    /// Red, green and blue of every stratum, in whole blocks of [`LANES`].
    rgb: [Vec<f32>; 3],
    /// Mean of the sum of squares of red, green and blue in every stratum.
    squares: Vec<f32>,
}

/// Sums over the light samples of one query, of red, green and blue.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ChannelSums {
    /// Radiance times geometry term of the visible samples, 1/m².
    pub visible: [f32; 3],
    /// Radiance times geometry term of all samples, 1/m².
    pub all: [f32; 3],
}

impl ChannelSums {
    /// Visible fraction of every channel; a channel of which nothing is emitted has that of the others. None where every sample
    /// lies below a horizon or is black.
    pub fn fractions(&self) -> Option<[f32; 3]> {
        let whole = self.fraction()?;
        Some(std::array::from_fn(|channel| match self.all[channel] {
            0.0 => whole,
            all => self.visible[channel] / all,
        }))
    }

    /// Visible fraction of the light as a vector of red, green and blue: the ratio of the lengths.
    pub fn fraction(&self) -> Option<f32> {
        let of = |rgb: [f32; 3]| Vec3::from_array(rgb).length();
        let all = of(self.all);
        (all > 0.0).then(|| of(self.visible) / all)
    }

    fn plus(self, other: Self) -> Self {
        let sum = |a: [f32; 3], b: [f32; 3]| std::array::from_fn(|channel| a[channel] + b[channel]);
        Self { visible: sum(self.visible, other.visible), all: sum(self.all, other.all) }
    }
}

impl StrataRadiance {
    /// Means of the texture of a light with this radiance.
    pub fn new(texture: &PlacedTexture, radiance: Vec3, pattern: Pattern) -> Self {
        let cells = texture.cells(pattern.columns, pattern.rows);
        let count = cells.len().next_multiple_of(LANES);
        let channel = |channel: usize| {
            let mut values: Vec<f32> = cells.iter().map(|cell| cell[channel] * radiance[channel]).collect();
            values.resize(count, 0.0);
            values
        };
        // The variation inside a stratum is that of the texture, whatever the colour of the light.
        let square = |cell: &Vec4| {
            let (mean, plain) =
                ((cell.truncate() * radiance).length_squared(), cell.truncate().length_squared());
            if plain > 0.0 { cell.w.max(plain) * mean / plain } else { 0.0 }
        };
        let squares = cells.iter().map(square).collect();
        Self { pattern, rgb: [0, 1, 2].map(channel), squares }
    }

    /// Pattern of the strata.
    pub fn pattern(&self) -> Pattern {
        self.pattern
    }

    fn bytes(&self) -> usize {
        let rgb: usize = self.rgb.iter().map(Vec::capacity).sum();
        (rgb + self.squares.capacity()) * size_of::<f32>()
    }

    /// Mean of the sum of squares of red, green and blue in a stratum.
    pub(crate) fn square(&self, stratum: usize) -> f32 {
        self.squares[stratum]
    }

    /// Red, green and blue of every stratum of the pattern, W/(m²·sr), and the mean of the sum of their squares.
    pub fn emissions(&self) -> impl Iterator<Item = Vec4> + '_ {
        (0..self.pattern.len()).map(|stratum| self.rgb(stratum).extend(self.square(stratum)))
    }

    /// Red, green and blue of a stratum.
    pub(crate) fn rgb(&self, stratum: usize) -> Vec3 {
        Vec3::from_array([0, 1, 2].map(|channel| self.rgb[channel][stratum]))
    }

    /// Sums over queries `first .. first + count` of a batch with the strata's pattern that has been answered.
    pub fn sums(&self, light: &AreaLight, batch: &MaskBatch, first: usize, count: usize) -> ChannelSums {
        let isa = Isa::best();
        let normal = light.normal();
        let query = |query| isa.run(QuerySums { light, normal, batch, strata: self, query });
        (first..first + count).map(query).fold(ChannelSums::default(), ChannelSums::plus)
    }

    /// Visible fractions of one query; none where every sample lies below a horizon.
    pub fn fractions(&self, light: &AreaLight, batch: &MaskBatch, query: usize) -> Option<ChannelSums> {
        match batch.lit_and_unlit(query) {
            (false, false) => None,
            (true, false) => Some(ChannelSums { visible: [1.0; 3], all: [1.0; 3] }),
            (false, true) => Some(ChannelSums { visible: [0.0; 3], all: [1.0; 3] }),
            (true, true) => Some(self.sums(light, batch, query, 1)),
        }
    }
}

/// Strata of the patterns that a light has been asked with.
#[derive(Clone, Debug, Default)]
pub(crate) struct StrataTable(Vec<StrataRadiance>);

impl StrataTable {
    /// Forgets the strata of the light before.
    pub(crate) fn clear(&mut self) {
        self.0.clear();
    }

    /// Computes the strata of a pattern, if they are not known.
    pub(crate) fn add(&mut self, texture: &PlacedTexture, radiance: Vec3, pattern: Pattern) {
        if self.of(pattern).is_none() {
            self.0.push(StrataRadiance::new(texture, radiance, pattern));
        }
    }

    /// Strata of a pattern, if they are known.
    pub(crate) fn of(&self, pattern: Pattern) -> Option<&StrataRadiance> {
        self.0.iter().find(|strata| strata.pattern == pattern)
    }

    pub(crate) fn bytes(&self) -> usize {
        self.0.iter().map(StrataRadiance::bytes).sum()
    }
}

struct QuerySums<'a> {
    light: &'a AreaLight,
    normal: Vec3,
    batch: &'a MaskBatch,
    strata: &'a StrataRadiance,
    query: usize,
}

impl Kernel for QuerySums<'_> {
    type Output = ChannelSums;

    #[inline(always)]
    fn run<S: Simd>(self) -> ChannelSums {
        let Self { light, normal, batch, strata, query: index } = self;
        let query = &batch.queries()[index];
        let mut sums = ChannelSums::default();
        let Some(facing) = facing(light, normal, query.origin) else { return sums };
        let (pattern, wanted, seen) = (batch.pattern(), batch.wanted(index), batch.visible(index));
        // Lane sums are kept apart to the end, so that every instruction set adds in the same order.
        let zero = S::Wide::splat(0.0);
        let (mut visible, mut all) = ([[zero; 2]; 3], [[zero; 2]; 3]);
        let origin = Vector::splat(query.origin);
        for block in 0..strata.rgb[0].len() / LANES {
            let (word, shift) = (block * LANES / 64, block * LANES % 64);
            let wanted = (wanted[word] >> shift) as u32 & 0xffff;
            let seen = (seen[word] >> shift) as u32 & wanted;
            if wanted == 0 {
                continue;
            }
            for (part, at) in (0..LANES).step_by(S::Wide::WIDTH).enumerate() {
                let first = block * LANES + at;
                let d = points::<S::Wide>(light, pattern, query.key, first).sub(origin);
                let terms = geometry_terms::<S::Wide>(d, query.normal, facing);
                let bits = S::Wide::ALL;
                for channel in 0..3 {
                    let light = terms.mul(S::Wide::load(&strata.rgb[channel][first..]));
                    all[channel][part] = all[channel][part].add(zero.select(wanted >> at & bits, light));
                    visible[channel][part] =
                        visible[channel][part].add(zero.select(seen >> at & bits, light));
                }
            }
        }
        for channel in 0..3 {
            let (mut lit, mut both) = ([0.0; LANES], [0.0; LANES]);
            for (part, at) in (0..LANES).step_by(S::Wide::WIDTH).enumerate() {
                visible[channel][part].store(&mut lit[at..]);
                all[channel][part].store(&mut both[at..]);
            }
            sums.visible[channel] = lit.iter().sum();
            sums.all[channel] = both.iter().sum();
        }
        sums
    }
}
