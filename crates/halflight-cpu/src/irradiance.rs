//! Values of the samples from their masks: irradiance by sampling, or the visible fraction.

use halflight_core::fragment::{Fragments, Sample};
use halflight_core::frame::Frame;
use halflight_core::light::AreaLight;
use halflight_core::mask::MaskBatch;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::dispatch::multiversion;
use crate::samples::{LANES, facing, geometry_terms, positions};

/// What is computed at the samples and interpolated between them.
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
    /// Irradiance per unit radiance of a light of this area (m²); 0 when there are no samples.
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

multiversion! {
    /// Sums over queries `first .. first + count` of a batch that has been answered.
    pub fn query_sums(light: &AreaLight, batch: &MaskBatch, first: usize, count: usize) -> Sums {
        let normal = light.normal();
        let mut sums = Sums::default();
        for index in first..first + count {
            sums = sums.plus(one_query(light, normal, batch, index));
        }
        sums
    }
}

#[inline(always)]
fn one_query(light: &AreaLight, light_normal: glam::Vec3, batch: &MaskBatch, index: usize) -> Sums {
    let query = &batch.queries()[index];
    let mut sums = Sums { count: query.asked, ..Sums::default() };
    let Some(facing) = facing(light, light_normal, query.origin) else { return sums };
    let pattern = batch.pattern();
    // Lane sums are kept apart to the end, so that every instruction set adds in the same order.
    let (mut visible, mut all) = ([0.0f32; LANES], [0.0f32; LANES]);
    for (word, (&wanted, &seen)) in batch.wanted(index).iter().zip(batch.visible(index)).enumerate() {
        for block in 0..64 / LANES {
            let wanted = (wanted >> (block * LANES)) as u16;
            if wanted == 0 {
                continue;
            }
            let seen = (seen >> (block * LANES)) as u16 & wanted;
            let positions = positions(light, pattern, query.key, word * 64 + block * LANES);
            let terms = geometry_terms(&positions, query.origin, query.normal, facing);
            for lane in 0..LANES {
                all[lane] += if wanted >> lane & 1 != 0 { terms[lane] } else { 0.0 };
                visible[lane] += if seen >> lane & 1 != 0 { terms[lane] } else { 0.0 };
            }
        }
    }
    for lane in 0..LANES {
        sums.visible += visible[lane];
        sums.all += all[lane];
    }
    sums
}

/// Computes the value of every sample.
pub fn evaluate(frame: &Frame, fragments: &Fragments, shading: Shading, values: &mut Vec<Option<f32>>) {
    let light = frame.light(fragments.light());
    let area = light.area();
    let value = |sample: &Sample| {
        if sample.probes == 0 {
            // Found to receive nothing, without asking: no irradiance, and a fraction that does not exist.
            return match shading {
                Shading::Sampled => Some(0.0),
                Shading::Ratio => None,
            };
        }
        let batch = fragments.batch(sample.batch);
        let sums = query_sums(light, batch, sample.first as usize, usize::from(sample.probes));
        match shading {
            Shading::Sampled => Some(sums.sampled(area)),
            Shading::Ratio => sums.fraction(),
        }
    };
    fragments.samples().par_iter().with_min_len(256).map(value).collect_into_vec(values);
}
