//! Values of the samples from their masks: irradiance by sampling, or the visible fraction.

use glam::Vec3;
use halflight_core::fragment::{Fragments, Sample};
use halflight_core::frame::Frame;
use halflight_core::light::AreaLight;
use halflight_core::light_texture::PlacedTexture;
use halflight_core::mask::{MaskBatch, Query};
use halflight_core::stages::RefineOutput;
use halflight_core::values::{NO_VALUE, Values};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::samples::{LANES, facing, geometry_terms, points};
use crate::simd::{Isa, Kernel, Lanes, Simd};
use crate::textured::StrataTable;
use crate::unshadowed::unshadowed;
use crate::vector::Vector;

/// Quantity that is computed at the samples and interpolated between them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Shading {
    /// Irradiance itself, `A/K Σ V cosθx cosθy / r²` (Koa17 Eq. 3 without 1/π).
    Sampled,
    /// The visible fraction `F = Σ g V / Σ g` (ratio estimator), times the analytic irradiance at every pixel.
    #[default]
    Ratio,
}

/// Sums over the light samples of one or more queries.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sums {
    /// Geometry terms of the visible samples, 1/m².
    pub visible: f32,
    /// Geometry terms of all samples, 1/m².
    pub all: f32,
    /// Number of samples, those below a horizon included.
    pub count: u32,
}

impl Sums {
    /// Irradiance per unit radiance of a light whose frame has this area (m²); 0 when there are no samples.
    pub fn sampled(&self, area: f32) -> f32 {
        if self.count == 0 { 0.0 } else { area * self.visible / self.count as f32 }
    }

    /// Visible fraction, or `None` when every sample lies below a horizon.
    pub fn fraction(&self) -> Option<f32> {
        (self.all > 0.0).then(|| self.visible / self.all)
    }

    fn plus(self, other: Self) -> Self {
        Self {
            visible: self.visible + other.visible,
            all: self.all + other.all,
            count: self.count + other.count,
        }
    }
}

/// Sums over queries `first .. first + count` of a batch that has been answered.
pub fn query_sums(light: &AreaLight, batch: &MaskBatch, first: usize, count: usize) -> Sums {
    sums(light, batch, first, count, Needed::Both)
}

/// Sums that are used.
#[derive(Clone, Copy, PartialEq)]
enum Needed {
    Both,
    /// The visible samples'.
    Visible,
}

fn sums(light: &AreaLight, batch: &MaskBatch, first: usize, count: usize, needed: Needed) -> Sums {
    let isa = Isa::best();
    let normal = light.normal();
    let mut sums = Sums::default();
    for query in first..first + count {
        sums = sums.plus(isa.run(QuerySums { light, normal, batch, query, needed }));
    }
    sums
}

/// Sums over the light samples of one query.
struct QuerySums<'a> {
    light: &'a AreaLight,
    normal: Vec3,
    batch: &'a MaskBatch,
    query: usize,
    needed: Needed,
}

impl Kernel for QuerySums<'_> {
    type Output = Sums;

    #[inline(always)]
    fn run<S: Simd>(self) -> Sums {
        let Self { light, normal, batch, query: index, needed } = self;
        let query = &batch.queries()[index];
        let mut sums = Sums { count: query.asked, ..Sums::default() };
        let seen = light.seen_from(query.origin);
        let (light, normal, sphere) = match light.as_sphere() {
            None => (light, normal, None),
            Some(_) if light.surrounds(query.origin) => return surrounded(light, query),
            Some(_) => (&*seen, seen.normal(), Some(light)),
        };
        let Some(facing) = facing(light, normal, query.origin) else { return sums };
        let (pattern, wanted, seen) = (batch.pattern(), batch.wanted(index), batch.visible(index));
        // Lane sums are kept apart to the end, so that every instruction set adds in the same order.
        let zero = S::Wide::splat(0.0);
        let (mut visible, mut all) = ([zero; 2], [zero; 2]);
        let origin = Vector::splat(query.origin);
        for block in 0..wanted.len() * 64 / LANES {
            let (word, shift) = (block * LANES / 64, block * LANES % 64);
            let wanted = (wanted[word] >> shift) as u32 & 0xffff;
            let seen = (seen[word] >> shift) as u32 & wanted;
            if wanted == 0 || seen == 0 && needed == Needed::Visible {
                continue;
            }
            for (part, at) in (0..LANES).step_by(S::Wide::WIDTH).enumerate() {
                let d = points::<S::Wide>(light, pattern, query.key, block * LANES + at).sub(origin);
                let terms = geometry_terms::<S::Wide>(d, query.normal, facing);
                let bits = S::Wide::ALL;
                all[part] = all[part].add(zero.select(wanted >> at & bits, terms));
                visible[part] = visible[part].add(zero.select(seen >> at & bits, terms));
            }
        }
        let (mut lit, mut both) = ([0.0; LANES], [0.0; LANES]);
        for (part, at) in (0..LANES).step_by(S::Wide::WIDTH).enumerate() {
            visible[part].store(&mut lit[at..]);
            all[part].store(&mut both[at..]);
        }
        for lane in 0..LANES {
            sums.visible += lit[lane];
            sums.all += both[lane];
        }
        if let Some(sphere) = sphere {
            // Sums are over areas of the sphere's own frame.
            let scale = light.frame_area() / sphere.frame_area();
            (sums.visible, sums.all) = (sums.visible * scale, sums.all * scale);
        }
        sums
    }
}

/// Sums of a receiver inside a sphere or on it: its irradiance in closed form, since all samples are visible.
fn surrounded(light: &AreaLight, query: &Query) -> Sums {
    let each = unshadowed(light, query.origin, query.normal) / light.frame_area();
    let all = each * query.asked as f32;
    Sums { visible: all, all, count: query.asked }
}

/// The visible fraction `F` of one query that has been answered, or `None` when every sample lies below a horizon: such
/// samples have been taken out of `wanted`.
pub fn fraction(light: &AreaLight, batch: &MaskBatch, query: usize) -> Option<f32> {
    // Most receivers are in the open or in the umbra, whatever their samples weigh.
    match batch.lit_and_unlit(query) {
        (false, false) => None,
        (true, false) => Some(1.0),
        (false, true) => Some(0.0),
        (true, true) => query_sums(light, batch, query, 1).fraction(),
    }
}

/// Sums over the visible samples of a textured light, over queries that have been answered: the geometry term, 1/m², times the texel that
/// the sample lies on; and the number of all samples, those below a horizon included.
pub fn texture_sums(
    light: &AreaLight,
    texture: &PlacedTexture,
    batch: &MaskBatch,
    first: usize,
    count: usize,
) -> (Vec3, u32) {
    let (normal, pattern) = (light.normal(), batch.pattern());
    let (mut sum, mut asked) = (Vec3::ZERO, 0);
    for index in first..first + count {
        let query = &batch.queries()[index];
        asked += query.asked;
        let Some(facing) = facing(light, normal, query.origin) else { continue };
        for (word, (&wanted, &visible)) in batch.wanted(index).iter().zip(batch.visible(index)).enumerate() {
            let mut seen = wanted & visible;
            while seen != 0 {
                let sample = word * 64 + seen.trailing_zeros() as usize;
                seen &= seen - 1;
                let uv = pattern.position(sample, query.key);
                let to = light.point(uv) - query.origin;
                let squared = to.length_squared();
                if squared > 0.0 {
                    let term = to.dot(query.normal).max(0.0) * (-to.dot(facing)).max(0.0);
                    sum += texture.at(uv) * (term / (squared * squared));
                }
            }
        }
    }
    (sum, asked)
}

/// Irradiance of red, green and blue per radiance of a textured light, over queries that have been answered.
pub fn sampled_texture(
    light: &AreaLight,
    texture: &PlacedTexture,
    batch: &MaskBatch,
    first: usize,
    count: usize,
) -> Vec3 {
    let (sum, asked) = texture_sums(light, texture, batch, first, count);
    if asked == 0 { Vec3::ZERO } else { sum * (light.frame_area() / asked as f32) }
}

/// Computes the value of every sample: in one channel, or in three where the light has a texture. `known` are what the refiner has found
/// of the first of them.
pub fn evaluate(
    frame: &Frame,
    fragments: &Fragments,
    shading: Shading,
    known: &RefineOutput,
    values: &mut Values,
) {
    match frame.light_texture(fragments.light()) {
        None => evaluate_uniform(frame, fragments, shading, known.fractions, values),
        Some(texture) => evaluate_textured(frame, fragments, shading, &texture, known, values),
    }
}

fn evaluate_textured(
    frame: &Frame,
    fragments: &Fragments,
    shading: Shading,
    texture: &PlacedTexture,
    known: &RefineOutput,
    values: &mut Values,
) {
    let (light, samples) = (frame.light(fragments.light()), fragments.samples());
    // Refiners that know one fraction only have it for all channels.
    let found = |index: usize| match known.colours.get(index) {
        Some(&colours) => Some(colours),
        None => known.fractions.get(index).map(|&fraction| [fraction; 3]),
    };
    let all = known.colours.len().max(known.fractions.len());
    let mut table = StrataTable::default();
    if all < samples.len() && shading == Shading::Ratio {
        fragments.batches().iter().for_each(|batch| table.add(texture, light.radiance, batch.pattern()));
    }
    let value = |(index, sample): (usize, &Sample)| {
        if let Some(known) = found(index).filter(|_| shading == Shading::Ratio) {
            return known;
        }
        let nothing = if shading == Shading::Sampled { 0.0 } else { NO_VALUE };
        if sample.probes == 0 {
            return [nothing; 3];
        }
        let (batch, first, count) =
            (fragments.batch(sample.batch), sample.first as usize, usize::from(sample.probes));
        if shading == Shading::Sampled {
            return sampled_texture(light, texture, batch, first, count).to_array();
        }
        let Some(strata) = table.of(batch.pattern()) else { return [nothing; 3] };
        let sums = if count == 1 {
            strata.fractions(light, batch, first)
        } else {
            Some(strata.sums(light, batch, first, count))
        };
        sums.and_then(|sums| sums.fractions()).unwrap_or([nothing; 3])
    };
    let rgb: Vec<[f32; 3]> = samples.par_iter().enumerate().with_min_len(256).map(value).collect();
    values.reset(3, samples.len());
    for channel in 0..3 {
        values.channel_mut(channel).iter_mut().zip(&rgb).for_each(|(place, rgb)| *place = rgb[channel]);
    }
}

/// Computes the value of every sample of a uniform light. `known` are the visible fractions of the first of them, [`NO_VALUE`] where
/// there is none.
fn evaluate_uniform(
    frame: &Frame,
    fragments: &Fragments,
    shading: Shading,
    known: &[f32],
    values: &mut Values,
) {
    let known = if shading == Shading::Ratio { known } else { &[] };
    let light = frame.light(fragments.light());
    let area = light.frame_area();
    let value = |sample: &Sample| {
        if sample.probes == 0 {
            // Found to receive nothing, without asking: no irradiance, and a fraction that does not exist.
            return match shading {
                Shading::Sampled => Some(0.0),
                Shading::Ratio => None,
            };
        }
        let batch = fragments.batch(sample.batch);
        if shading == Shading::Ratio && sample.probes == 1 {
            return fraction(light, batch, sample.first as usize);
        }
        let sums = |needed| sums(light, batch, sample.first as usize, usize::from(sample.probes), needed);
        match shading {
            Shading::Sampled => Some(sums(Needed::Visible).sampled(area)),
            Shading::Ratio => sums(Needed::Both).fraction(),
        }
    };
    let samples = fragments.samples();
    values.reset(1, samples.len());
    let places = values.channel_mut(0).par_iter_mut().zip(samples).enumerate().with_min_len(256);
    places.for_each(|(index, (place, sample))| {
        *place = known.get(index).copied().unwrap_or_else(|| value(sample).unwrap_or(NO_VALUE));
    });
}
