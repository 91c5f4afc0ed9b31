//! Multi-pass bilinear upsampling.

use halflight_core::fragment::{Cell, Fragments};
use halflight_core::frame::Frame;
use halflight_core::stages::Upsampler;
use halflight_core::values::NO_VALUE;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::cells::Field;
use super::surface::{SurfaceLimits, Surfaces};

/// Texel whose surface is not known.
const NOWHERE: u32 = u32::MAX;

/// Configuration of [`Bilinear`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BilinearConfig {
    /// Limits beyond which surfaces are separated by an edge. The paper says "edge-aware" (Nichols10 §3.4)
    /// and gives no numbers; these values are not from the paper.
    pub surface: SurfaceLimits,
}

/// Bilinear upsampling level by level, from the coarsest to the finest (Nichols10 §3.4, after Nichols & Wyman
/// 2009).
///
/// A texel of a level is *computed* when a fragment of that level or of a coarser one covers it. It holds the
/// fragment's first sample, or an interpolation between the four nearest computed texels of the next coarser
/// level, weighted 9 : 3 : 3 : 1 and without those across an edge. A texel that was split further is not
/// computed and never used. Values therefore flow from coarse to fine only: at shadow edges coarse fragments
/// dominate, the artefact that Koa17 shows in Fig. 7a. Where all four are across an edge, edges are ignored.
#[derive(Debug, Default)]
pub struct Bilinear {
    config: BilinearConfig,
    owners: Vec<u32>,
    levels: Vec<Level>,
}

/// Image of one level: coarse values, each with its representative pixel.
#[derive(Debug, Default)]
struct Level {
    width: u32,
    height: u32,
    texels: Vec<Texel>,
}

#[derive(Clone, Copy, Debug)]
struct Texel {
    /// [`NO_VALUE`] where not computed.
    value: f32,
    pixel: u32,
}

impl Texel {
    const EMPTY: Self = Self { value: NO_VALUE, pixel: NOWHERE };
}

impl Bilinear {
    /// Creates an upsampler without buffers.
    pub fn new(config: BilinearConfig) -> Self {
        Self { config, ..Self::default() }
    }
}

impl Upsampler for Bilinear {
    fn upsample(&mut self, frame: &Frame, fragments: &Fragments, values: &[f32], out: &mut [f32]) {
        let Some(field) = Field::new(frame.gbuffer, fragments, values, &mut self.owners, out) else {
            out.fill(0.0);
            return;
        };
        let pass = Pass { field, surfaces: Surfaces::new(frame, &self.config.surface) };
        let top = field.cells().iter().map(|cell| usize::from(cell.level)).max().unwrap_or(0);
        if self.levels.len() <= top {
            self.levels.resize_with(top + 1, Level::default);
        }
        for level in (1..=top).rev() {
            let (finer, coarser) = self.levels.split_at_mut(level + 1);
            let coarse = coarser.first().filter(|_| level < top);
            let target = &mut finer[level];
            let size = 1u32 << level;
            target.width = field.width.div_ceil(size);
            target.height = field.height.div_ceil(size);
            let count = target.width as usize * target.height as usize;
            target.texels.resize(count, Texel::EMPTY);
            let width = target.width as usize;
            target.texels.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
                for (x, texel) in row.iter_mut().enumerate() {
                    *texel = pass.texel(level as u8, x as u32, y as u32, coarse);
                }
            });
        }
        let coarse = self.levels.get(1).filter(|_| top > 0);
        out.par_chunks_mut(field.width as usize).enumerate().for_each(|(y, row)| {
            for (x, pixel) in row.iter_mut().enumerate() {
                let value = pass.texel(0, x as u32, y as u32, coarse).value;
                *pixel = if value.is_nan() { 0.0 } else { value };
            }
        });
    }

    fn bytes(&self) -> usize {
        self.owners.capacity() * 4
            + self.levels.iter().map(|level| level.texels.capacity() * size_of::<Texel>()).sum::<usize>()
    }
}

/// Data that all levels share.
struct Pass<'a> {
    field: Field<'a>,
    surfaces: Surfaces<'a>,
}

impl Pass<'_> {
    #[inline]
    fn texel(&self, level: u8, x: u32, y: u32, coarse: Option<&Level>) -> Texel {
        if level == 0 && !self.surfaces.is_receiver(self.field.pixel(x, y)) {
            return Texel::EMPTY;
        }
        let Some(cell) = self.field.owner(x << level, y << level).filter(|cell| cell.level >= level) else {
            return Texel::EMPTY;
        };
        if cell.level == level
            && let Some(texel) = self.own(cell)
        {
            return texel;
        }
        coarse.map_or(Texel::EMPTY, |coarse| self.interpolate(level, x, y, coarse))
    }

    /// Value of a cell as a whole.
    #[inline]
    fn own(&self, cell: &Cell) -> Option<Texel> {
        let &first = self.field.samples_of(cell).first()?;
        Some(Texel { value: self.field.value(first)?, pixel: self.field.sample(first)?.pixel })
    }

    /// Edge-aware bilinear interpolation in the next coarser level.
    #[inline]
    fn interpolate(&self, level: u8, x: u32, y: u32, coarse: &Level) -> Texel {
        // Neighbour on the texel's own side; at the border the parent again.
        let side = |at: u32, count: u32| {
            if at & 1 == 1 { (at / 2 + 1).min(count - 1) } else { (at / 2).saturating_sub(1) }
        };
        let (px, py) = (x / 2, y / 2);
        let (sx, sy) = (side(x, coarse.width), side(y, coarse.height));
        let at = |x: u32, y: u32| coarse.texels[(y * coarse.width + x) as usize];
        let taps = [(at(px, py), 9.0), (at(sx, py), 3.0), (at(px, sy), 3.0), (at(sx, sy), 1.0)];

        let pixel = self.stand_in(level, x, y).unwrap_or(taps[0].0.pixel);
        let first = taps[0].0.value;
        if taps.iter().all(|(tap, _)| tap.value == first) {
            return Texel { value: first, pixel };
        }
        let (mut sum, mut total, mut plain, mut plain_total) = (0.0, 0.0, 0.0, 0.0);
        for (tap, weight) in taps {
            if tap.value.is_nan() {
                continue;
            }
            plain += weight * tap.value;
            plain_total += weight;
            if self.surfaces.same_primitive(pixel, tap.pixel) {
                sum += weight * tap.value;
                total += weight;
            } else if pixel != NOWHERE && tap.pixel != NOWHERE {
                let patch = self.surfaces.patch(pixel as usize);
                let other = self.surfaces.patch(tap.pixel as usize);
                let weight = weight * self.surfaces.agreement(&patch, other.position, other.normal);
                sum += weight * tap.value;
                total += weight;
            }
        }
        let value = match (total > 0.0, plain_total > 0.0) {
            (true, _) => sum / total,
            (false, true) => plain / plain_total,
            _ => NO_VALUE,
        };
        Texel { value, pixel }
    }

    /// Representative pixel of a texel, right of and below its centre, if it sees geometry.
    #[inline]
    fn stand_in(&self, level: u8, x: u32, y: u32) -> Option<u32> {
        let half = (1u32 << level) / 2;
        let x = ((x << level) + half).min(self.field.width - 1);
        let y = ((y << level) + half).min(self.field.height - 1);
        let pixel = self.field.pixel(x, y);
        self.surfaces.is_receiver(pixel).then_some(pixel as u32)
    }
}
