//! Robust upsampler: compact radial basis functions with a linear term, aware of surfaces.

use halflight_core::fragment::Fragments;
use halflight_core::frame::Frame;
use halflight_core::glam::Vec3;
use halflight_core::stages::Upsampler;
use serde::{Deserialize, Serialize};

use super::cells::{Field, Piece, Rows, TILE_PIXELS};
use super::nearby::{Known, Nearby, Role, Source, assign_roles};
use super::surface::{Patch, SurfaceLimits, Surfaces};
use crate::multiversion::multiversion;

/// Number of pixels that are computed together.
const LANES: usize = 8;

/// Configuration of [`RbfRobust`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RbfRobustConfig {
    /// Limits within which pixels belong to the same surface.
    pub surface: SurfaceLimits,
    /// Radius of a sample's influence, in units of the spacing of samples in its cell.
    pub radius: f32,
    /// Distance, in pixels, below which the weight of a sample stops growing.
    pub softness_px: f32,
    /// Regularisation of the fit's slope: fraction of the samples' spread that is added to it. Above 0, the
    /// fit exists even where all samples lie on a line.
    pub stiffness: f32,
}

impl Default for RbfRobustConfig {
    fn default() -> Self {
        Self { surface: SurfaceLimits::default(), radius: 2.0, softness_px: 1.0, stiffness: 0.1 }
    }
}

/// Upsampling by compact radial basis functions, normalised, with a linear term, clamped to the bounds of the
/// samples.
///
/// The weight of a sample is `(1 - t)² / (t + s²/r²)` at `t = (d/r)²`, with `d` its distance and `r`
/// proportional to the spacing of samples in its cell, times the agreement of its surface with the pixel's.
/// Nearer samples therefore have more weight, and each has a weight in proportion to the area that it
/// represents: many single pixels do not outweigh the fragment beside them.
///
/// The pixel's value is the weighted least-squares plane through the samples, evaluated at the pixel and
/// clamped to the least and largest sample that was used. Constants and (away from borders) ramps are
/// reproduced, and nothing overshoots. No matrix can be singular, since the spread of the samples is padded
/// before it is inverted.
///
/// The samples are those of the pixel's cell and of all cells around it. If none of them lies on the pixel's
/// surface, two wider rings are used; if still none does, all are averaged by the match of their surfaces.
/// Cells of all levels are interpolated; a pixel that is a sample itself keeps its value.
#[derive(Debug, Default)]
pub struct RbfRobust {
    config: RbfRobustConfig,
    owners: Vec<u32>,
    roles: Vec<Role>,
}

impl RbfRobust {
    /// Creates an upsampler without buffers.
    pub fn new(config: RbfRobustConfig) -> Self {
        Self { config, ..Self::default() }
    }
}

impl Upsampler for RbfRobust {
    fn upsample(&mut self, frame: &Frame, fragments: &Fragments, values: &[f32], out: &mut [f32]) {
        let Some(field) = Field::new(frame.gbuffer, fragments, values, &mut self.owners, out) else {
            out.fill(0.0);
            return;
        };
        let surfaces = Surfaces::new(frame, &self.config.surface);
        assign_roles(&field, &surfaces, self.config.radius.max(1.0), &mut self.roles);
        let source = Source { field: &field, surfaces: &surfaces, roles: &self.roles };
        let fit = Fit::new(&self.config);
        field.for_each_piece(out, |piece, rows, scratch: &mut Scratch| {
            scratch.fill(&source, &fit, piece, rows, false);
        });
        field.write_exact(frame.gbuffer, out);
    }

    fn bytes(&self) -> usize {
        self.owners.capacity() * 4 + self.roles.capacity() * size_of::<Role>()
    }
}

/// Constants of the fit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fit {
    softness2: f32,
    stiffness: f32,
}

impl Fit {
    pub(super) fn new(config: &RbfRobustConfig) -> Self {
        Self { softness2: config.softness_px.max(1e-3).powi(2), stiffness: config.stiffness.max(1e-4) }
    }
}

/// Scratch memory of one thread.
#[derive(Default)]
pub(super) struct Scratch {
    near: Nearby,
    wide: Nearby,
    block: Block,
}

/// Pixels of a piece, one array per attribute.
struct Block {
    len: usize,
    pixel: [u32; TILE_PIXELS],
    x: [f32; TILE_PIXELS],
    y: [f32; TILE_PIXELS],
    position: [[f32; TILE_PIXELS]; 3],
    normal: [[f32; TILE_PIXELS]; 3],
    allowed: [f32; TILE_PIXELS],
    value: [f32; TILE_PIXELS],
    /// True for pixels that used any sample.
    found: [bool; TILE_PIXELS],
}

impl Default for Block {
    fn default() -> Self {
        let zero = [0.0; TILE_PIXELS];
        Self {
            len: 0,
            pixel: [0; TILE_PIXELS],
            x: zero,
            y: zero,
            position: [zero; 3],
            normal: [zero; 3],
            allowed: [1.0; TILE_PIXELS],
            value: zero,
            found: [false; TILE_PIXELS],
        }
    }
}

impl Scratch {
    /// Writes the pixels of a piece; with `rest` only those without a value so far.
    pub(super) fn fill(&mut self, source: &Source, fit: &Fit, piece: &Piece, rows: &mut Rows, rest: bool) {
        let field = source.field;
        if piece.cell.level == 0
            && let Some(&index) = field.samples_of(piece.cell).first()
        {
            let pixel = field.pixel(piece.rect.x0, piece.rect.y0);
            let value = field.value(index).unwrap_or(field.anything);
            rows.set(pixel, if source.surfaces.is_receiver(pixel) { value } else { 0.0 });
            return;
        }
        if rest && !piece.rect.pixels().any(|(x, y)| rows.get(field.pixel(x, y)).is_nan()) {
            return;
        }
        self.near.gather(source, piece);
        let bounds = self.near.bounds();
        if let Some((low, high)) = bounds
            && low == high
        {
            // All samples around agree: every weighting gives the same value.
            for (x, y) in piece.rect.pixels() {
                let pixel = field.pixel(x, y);
                if !rest || rows.get(pixel).is_nan() {
                    rows.set(pixel, if source.surfaces.is_receiver(pixel) { low } else { 0.0 });
                }
            }
            return;
        }
        self.block.load(source, piece, rows, rest);
        let plane = self.near.plane(source.surfaces);
        let flat = plane.is_some_and(|plane| self.block.lies_on(&plane, source.surfaces));
        fit_block(fit, source.surfaces, self.near.samples(), flat, &mut self.block);
        let block = &self.block;
        let mut widened = false;
        for lane in 0..block.len {
            let value = if block.found[lane] {
                block.value[lane]
            } else {
                if !widened {
                    self.wide.gather_wide(source, piece);
                    widened = true;
                }
                let patch = source.surfaces.patch(block.pixel[lane] as usize);
                self.wide.average(source.surfaces, block.x[lane], block.y[lane], &patch)
            };
            rows.set(block.pixel[lane] as usize, value);
        }
    }
}

impl Block {
    fn lies_on(&self, plane: &Patch, surfaces: &Surfaces) -> bool {
        let [px, py, pz] = &self.position;
        let [nx, ny, nz] = &self.normal;
        (0..self.len).all(|lane| {
            let position = Vec3::new(px[lane], py[lane], pz[lane]);
            let normal = Vec3::new(nx[lane], ny[lane], nz[lane]);
            surfaces.lies_on(plane, position, normal, self.allowed[lane])
        })
    }

    /// Loads the pixels of a piece that see geometry, and writes 0 to the others; with `rest` only those
    /// without a value.
    fn load(&mut self, source: &Source, piece: &Piece, rows: &mut Rows, rest: bool) {
        self.len = 0;
        for (x, y) in piece.rect.pixels() {
            let pixel = source.field.pixel(x, y);
            if !source.surfaces.is_receiver(pixel) {
                rows.set(pixel, 0.0);
                continue;
            }
            if rest && !rows.get(pixel).is_nan() {
                continue;
            }
            let Patch { position, normal, allowed } = source.surfaces.patch(pixel);
            let lane = self.len;
            self.pixel[lane] = pixel as u32;
            (self.x[lane], self.y[lane]) = (x as f32 + 0.5, y as f32 + 0.5);
            for axis in 0..3 {
                self.position[axis][lane] = position[axis];
                self.normal[axis][lane] = normal[axis];
            }
            self.allowed[lane] = allowed;
            self.len += 1;
        }
    }
}

multiversion! {
    /// Fits all pixels of the block; `flat` is true if they and the samples all agree. Lanes past the end
    /// compute unused values.
    fn fit_block(fit: &Fit, surfaces: &Surfaces, samples: &[Known], flat: bool, block: &mut Block) {
        for start in (0..block.len).step_by(LANES) {
            if flat {
                fit_lanes::<true>(fit, surfaces, samples, block, start);
            } else {
                fit_lanes::<false>(fit, surfaces, samples, block, start);
            }
        }
    }
}

#[inline(always)]
fn fit_lanes<const FLAT: bool>(
    fit: &Fit,
    surfaces: &Surfaces,
    samples: &[Known],
    block: &mut Block,
    start: usize,
) {
    const ZERO: [f32; LANES] = [0.0; LANES];
    // Weighted sums of 1, x, y, v, x², xy, y², xv, yv relative to the pixel.
    let mut sums = [ZERO; 9];
    let (mut low, mut high) = ([f32::INFINITY; LANES], [f32::NEG_INFINITY; LANES]);
    let column = |from: &[f32; TILE_PIXELS]| std::array::from_fn::<f32, LANES, _>(|lane| from[start + lane]);
    let (x, y, allowed) = (column(&block.x), column(&block.y), column(&block.allowed));
    let [px, py, pz] = block.position.each_ref().map(column);
    let [nx, ny, nz] = block.normal.each_ref().map(column);
    for known in samples {
        for lane in 0..LANES {
            let patch = Patch {
                position: Vec3::new(px[lane], py[lane], pz[lane]),
                normal: Vec3::new(nx[lane], ny[lane], nz[lane]),
                allowed: allowed[lane],
            };
            let same = if FLAT { 1.0 } else { surfaces.agreement(&patch, known.position, known.normal) };
            let (dx, dy) = (known.x - x[lane], known.y - y[lane]);
            let away = (dx * dx + dy * dy) * known.inverse_reach2;
            let rest = (1.0 - away).max(0.0);
            let weight = known.trust * same * rest * rest / (away + fit.softness2 * known.inverse_reach2);
            let (wx, wy) = (weight * dx, weight * dy);
            sums[0][lane] += weight;
            sums[1][lane] += wx;
            sums[2][lane] += wy;
            sums[3][lane] += weight * known.value;
            sums[4][lane] += wx * dx;
            sums[5][lane] += wx * dy;
            sums[6][lane] += wy * dy;
            sums[7][lane] += wx * known.value;
            sums[8][lane] += wy * known.value;
            let used = weight > 0.0;
            low[lane] = if used && known.value < low[lane] { known.value } else { low[lane] };
            high[lane] = if used && known.value > high[lane] { known.value } else { high[lane] };
        }
    }
    for lane in 0..LANES {
        let total = sums[0][lane];
        block.found[start + lane] = total > 1e-20;
        let scale = 1.0 / total.max(1e-20);
        let (mx, my, mv) = (sums[1][lane] * scale, sums[2][lane] * scale, sums[3][lane] * scale);
        let (xx, yy) = (sums[4][lane] * scale - mx * mx, sums[6][lane] * scale - my * my);
        let xy = sums[5][lane] * scale - mx * my;
        let (xv, yv) = (sums[7][lane] * scale - mx * mv, sums[8][lane] * scale - my * mv);
        // Rounding can make a spread negative; the padding covers it.
        let padding = fit.stiffness * (xx + yy).max(0.0) + 1e-3 * (mx * mx + my * my) + 1e-4;
        let (xx, yy) = (xx.max(0.0) + padding, yy.max(0.0) + padding);
        let determinant = (xx * yy - xy * xy).max(padding * padding * 0.5);
        let (gx, gy) = ((yy * xv - xy * yv) / determinant, (xx * yv - xy * xv) / determinant);
        let value = mv - gx * mx - gy * my;
        block.value[start + lane] = value.max(low[lane]).min(high[lane]);
    }
}
