//! Lattice upsampler: bilinear interpolation between the corners of cells.

use halflight_core::fragment::{Cell, Fragments};
use halflight_core::frame::Frame;
use halflight_core::stages::Upsampler;
use halflight_core::values::NO_VALUE;
use serde::{Deserialize, Serialize};

use super::cells::{Field, Piece, Rows};
use super::nearby::{Role, Source, assign_roles};
use super::robust::{Fit, RbfRobustConfig, Scratch};
use super::surface::Surfaces;
use crate::corners::Corners;
use crate::tangent_plane::{DiscontinuityLimits, TangentPlanes};

/// Configuration of [`Lattice`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LatticeConfig {
    /// Limits of the tangent-plane test.
    #[serde(alias = "rise")]
    pub discontinuity: DiscontinuityLimits,
    /// Options of the RBF for pixels without a corner on their surface, and for cells without a sample at
    /// each corner.
    pub rest: RbfRobustConfig,
}

/// Bilinear interpolation over cells that have samples at their corners: their first pixel and the first
/// pixels of the cells right of and below them, clamped to the image's last column and row.
///
/// A corner is left out if a surface discontinuity separates it from the pixel: one of the two lies above the
/// other's tangent plane. The others' weights are renormalised. Convex surfaces are interpolated over; depth
/// discontinuities and concave creases are not. Constants and, on one surface, ramps are reproduced, and no
/// value lies outside the bounds of its corners. Cells of other refiners, and pixels without a usable corner,
/// are computed by [`RbfRobust`](super::RbfRobust).
#[derive(Debug, Default)]
pub struct Lattice {
    config: LatticeConfig,
    owners: Vec<u32>,
    roles: Vec<Role>,
}

impl Lattice {
    /// Creates an upsampler without buffers.
    pub fn new(config: LatticeConfig) -> Self {
        Self { config, ..Self::default() }
    }
}

impl Upsampler for Lattice {
    fn upsample(&mut self, frame: &Frame, fragments: &Fragments, values: &[f32], out: &mut [f32]) {
        let Some(field) = Field::new(frame.gbuffer, fragments, values, &mut self.owners, out) else {
            out.fill(0.0);
            return;
        };
        let pass = Pass { field: &field, planes: TangentPlanes::new(frame, &self.config.discontinuity) };
        field.for_each_piece(out, |piece, rows, (): &mut ()| pass.fill(piece, rows));
        if !out.iter().any(|value| value.is_nan()) {
            return;
        }
        let surfaces = Surfaces::new(frame, &self.config.rest.surface);
        assign_roles(&field, &surfaces, self.config.rest.radius.max(1.0), &mut self.roles);
        let source = Source { field: &field, surfaces: &surfaces, roles: &self.roles };
        let fit = Fit::new(&self.config.rest);
        field.for_each_piece(out, |piece, rows, scratch: &mut Scratch| {
            scratch.fill(&source, &fit, piece, rows, true);
        });
    }

    fn bytes(&self) -> usize {
        self.owners.capacity() * 4 + self.roles.capacity() * size_of::<Role>()
    }
}

fn all_known(values: &[f32; 4]) -> bool {
    !values.iter().any(|value| value.is_nan())
}

/// Data that all cells share.
struct Pass<'a> {
    field: &'a Field<'a>,
    planes: TangentPlanes<'a>,
}

impl Pass<'_> {
    /// Writes the pixels of a piece; [`NO_VALUE`] where no corner is usable.
    fn fill(&self, piece: &Piece, rows: &mut Rows) {
        let field = self.field;
        if piece.cell.level == 0
            && let &[sample] = field.samples_of(piece.cell)
        {
            let pixel = field.pixel(piece.rect.x0, piece.rect.y0);
            let receives = self.planes.is_receiver(pixel);
            rows.set(pixel, if receives { field.value(sample).unwrap_or(field.anything) } else { 0.0 });
            return;
        }
        let Some((corners, values)) = self.corner_values(piece.cell) else {
            for (x, y) in piece.rect.pixels() {
                rows.set(field.pixel(x, y), NO_VALUE);
            }
            return;
        };
        let low = values.iter().copied().fold(f32::INFINITY, f32::min);
        let high = values.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        let triangle = self.planes.triangle(&corners.pixels()).filter(|_| low < high && all_known(&values));
        for (x, y) in piece.rect.pixels() {
            let pixel = field.pixel(x, y);
            let value = if !self.planes.is_receiver(pixel) {
                0.0
            } else if triangle == self.planes.triangle(&[pixel]) && triangle.is_some() {
                // All on one triangle: the most common case of values that vary.
                let weights = corners.weights(x, y);
                let sum = weights[0] * values[0] + weights[1] * values[1];
                (sum + weights[2] * values[2] + weights[3] * values[3]).clamp(low, high)
            } else if low < high {
                let value = corners.interpolate(&self.planes, &values, x, y);
                // NaN: all corners on the pixel's surface have the light below their horizons, and the pixel
                // gets almost none. Clamped, since rounding must not lead out of the bounds.
                if value.is_nan() { 0.5 * (low + high) } else { value.clamp(low, high) }
            } else if low == high {
                low
            } else {
                field.anything
            };
            rows.set(pixel, value);
        }
    }

    /// Corners of a cell with their values, if all of them are among its samples.
    fn corner_values(&self, cell: &Cell) -> Option<(Corners, [f32; 4])> {
        let field = self.field;
        let corners =
            Corners::new(field.width, field.height, cell.level, u32::from(cell.x), u32::from(cell.y));
        let samples = field.samples_of(cell);
        let mut values = [NO_VALUE; 4];
        for (value, pixel) in values.iter_mut().zip(corners.pixels()) {
            if !self.planes.is_receiver(pixel) {
                continue;
            }
            let is_here = |&&index: &&u32| field.sample(index).is_some_and(|s| s.pixel as usize == pixel);
            *value = field.value(*samples.iter().find(is_here)?).unwrap_or(NO_VALUE);
        }
        Some((corners, values))
    }
}
