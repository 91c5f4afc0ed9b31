//! Upsampling by interpolation on the Delaunay triangulation of the samples.

use halflight_core::fragment::{Cell, Fragments};
use halflight_core::frame::Frame;
use halflight_core::stages::Upsampler;
use halflight_core::values::NO_VALUE;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use spade::{DelaunayTriangulation, HasPosition, Point2, Triangulation};

use super::cells::{Field, TILE};
use super::nearby::{Role, Source, assign_roles};
use super::robust::{Fit, RbfRobustConfig, Scratch};
use super::surface::{SurfaceLimits, Surfaces};

/// Barycentric coordinate, negated, down to which a pixel is inside a triangle, so that rounding leaves no
/// gap between triangles.
const INSIDE: f32 = 1e-5;

/// Configuration of [`Delaunay`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DelaunayConfig {
    /// Limits within which pixels belong to the same surface.
    pub surface: SurfaceLimits,
}

/// Barycentric interpolation on the Delaunay triangulation of the samples.
///
/// A corner on another surface than the pixel is left out and the others' weights are renormalised. Pixels
/// outside the triangulation, and pixels without a corner on their surface, are computed by
/// [`RbfRobust`](super::RbfRobust). A pixel that is a sample itself keeps its value; single-pixel samples
/// whose neighbours are all single-pixel samples are not triangulated. The triangulation itself runs on one
/// thread and allocates anew every frame.
#[derive(Debug, Default)]
pub struct Delaunay {
    config: DelaunayConfig,
    owners: Vec<u32>,
    roles: Vec<Role>,
    taken: Vec<bool>,
    triangles: Vec<[u32; 3]>,
    /// First entry of every band in `order`.
    bands: Vec<u32>,
    /// Triangles sorted by the bands of rows that they touch.
    order: Vec<u32>,
}

impl Delaunay {
    /// Creates an upsampler without buffers.
    pub fn new(config: DelaunayConfig) -> Self {
        Self { config, ..Self::default() }
    }
}

/// Sample as a vertex of the triangulation.
#[derive(Clone, Copy, Debug)]
struct Vertex {
    x: f32,
    y: f32,
    sample: u32,
}

impl HasPosition for Vertex {
    type Scalar = f32;

    fn position(&self) -> Point2<f32> {
        Point2::new(self.x, self.y)
    }
}

impl Upsampler for Delaunay {
    fn upsample(&mut self, frame: &Frame, fragments: &Fragments, values: &[f32], out: &mut [f32]) {
        let Some(field) = Field::new(frame.gbuffer, fragments, values, &mut self.owners, out) else {
            out.fill(0.0);
            return;
        };
        let vertices = vertices(&field, &mut self.taken);
        // The vertices are finite; should the triangulation fail nevertheless, every pixel counts as outside
        // it.
        let mesh = DelaunayTriangulation::<Vertex>::bulk_load(vertices).unwrap_or_default();
        self.triangles.clear();
        self.triangles.extend(mesh.inner_faces().map(|face| face.vertices().map(|v| v.data().sample)));
        sort_into_bands(&field, &mut self.triangles, &mut self.bands, &mut self.order);

        let robust = RbfRobustConfig { surface: self.config.surface, ..RbfRobustConfig::default() };
        let surfaces = Surfaces::new(frame, &self.config.surface);
        assign_roles(&field, &surfaces, robust.radius, &mut self.roles);
        let source = Source { field: &field, surfaces: &surfaces, roles: &self.roles };

        let band = field.width as usize * TILE as usize;
        out.par_chunks_mut(band).enumerate().for_each(|(index, pixels)| {
            pixels.fill(NO_VALUE);
            for &triangle in &self.order[self.bands[index] as usize..self.bands[index + 1] as usize] {
                rasterize(&source, self.triangles[triangle as usize], index as u32 * TILE, pixels);
            }
        });
        let fit = Fit::new(&robust);
        field.for_each_piece(out, |piece, rows, scratch: &mut Scratch| {
            scratch.fill(&source, &fit, piece, rows, true);
        });
        field.write_exact(frame.gbuffer, out);
    }

    fn bytes(&self) -> usize {
        (self.owners.capacity() + self.bands.capacity() + self.order.capacity()) * 4
            + self.roles.capacity() * size_of::<Role>()
            + self.taken.capacity()
            + self.triangles.capacity() * size_of::<[u32; 3]>()
    }
}

/// Samples to triangulate, in the order of the cells.
fn vertices(field: &Field, taken: &mut Vec<bool>) -> Vec<Vertex> {
    taken.clear();
    taken.resize(field.sample_count(), false);
    let mut vertices = Vec::new();
    for cell in field.cells() {
        if is_enclosed(field, cell) {
            continue;
        }
        for &index in field.samples_of(cell) {
            if let Some(sample) = field.sample(index)
                && field.value(index).is_some()
                && !std::mem::replace(&mut taken[index as usize], true)
            {
                vertices.push(Vertex { x: sample.x, y: sample.y, sample: index });
            }
        }
    }
    vertices
}

/// True if the cell is a pixel, and all pixels around it have values of their own.
fn is_enclosed(field: &Field, cell: &Cell) -> bool {
    if cell.level != 0 {
        return false;
    }
    let (x, y) = (u32::from(cell.x), u32::from(cell.y));
    let mut enclosed = true;
    for y in y.saturating_sub(1)..(y + 2).min(field.height) {
        for x in x.saturating_sub(1)..(x + 2).min(field.width) {
            enclosed &= field.owner(x, y).is_none_or(|other| {
                other.level == 0 && field.samples_of(other).first().is_some_and(|&s| field.value(s).is_some())
            });
        }
    }
    enclosed
}

/// Drops triangles between neighbouring pixels and sorts the others by the bands of [`TILE`] rows that they
/// touch.
fn sort_into_bands(field: &Field, triangles: &mut Vec<[u32; 3]>, bands: &mut Vec<u32>, order: &mut Vec<u32>) {
    let corners = |triangle: &[u32; 3]| triangle.map(|s| field.sample(s).map_or((0.0, 0.0), |s| (s.x, s.y)));
    triangles.retain(|triangle| {
        let [a, b, c] = corners(triangle);
        let wide = |a: f32, b: f32, c: f32| a.max(b).max(c) - a.min(b).min(c) > 1.0;
        wide(a.0, b.0, c.0) || wide(a.1, b.1, c.1)
    });
    let count = field.height.div_ceil(TILE);
    let touched = |triangle: &[u32; 3]| {
        let [a, b, c] = corners(triangle);
        let first = (a.1.min(b.1).min(c.1).max(0.0) as u32 / TILE).min(count);
        let last = (a.1.max(b.1).max(c.1).max(0.0) as u32 / TILE).saturating_add(1).min(count);
        first..last
    };
    // Counting sort: counts are accumulated to ends, which are then decremented to starts.
    bands.clear();
    bands.resize(count as usize + 1, 0);
    for triangle in triangles.iter() {
        for band in touched(triangle) {
            bands[band as usize] += 1;
        }
    }
    let mut end = 0;
    for band in bands.iter_mut() {
        end += *band;
        *band = end;
    }
    order.clear();
    order.resize(end as usize, 0);
    for (index, triangle) in triangles.iter().enumerate().rev() {
        for band in touched(triangle) {
            let slot = &mut bands[band as usize];
            *slot -= 1;
            order[*slot as usize] = index as u32;
        }
    }
}

/// Writes the pixels of a band that lie in the triangle and share a surface with any of its corners.
fn rasterize(source: &Source, triangle: [u32; 3], top: u32, pixels: &mut [f32]) {
    let field = source.field;
    let [Some(a), Some(b), Some(c)] = triangle.map(|index| field.sample(index)) else { return };
    let values = triangle.map(|index| field.value(index).unwrap_or(0.0));
    let (ux, uy, vx, vy) = (b.x - a.x, b.y - a.y, c.x - a.x, c.y - a.y);
    let area = ux * vy - uy * vx;
    if area == 0.0 {
        return;
    }
    let scale = 1.0 / area;
    let trust = triangle.map(|index| source.trust(index));
    let patches = [a, b, c].map(|sample| source.surfaces.patch(sample.pixel as usize));
    // Pixel (x, y) has its centre half a pixel further.
    let span = |p: f32, q: f32, r: f32, low: u32, high: u32| {
        let first = ((p.min(q).min(r) - 0.5 - INSIDE).ceil().max(0.0) as u32).max(low);
        let last = ((p.max(q).max(r) - 0.5 + INSIDE).floor().max(-1.0) + 1.0) as u32;
        first..last.min(high)
    };
    let rows = pixels.len() as u32 / field.width;
    for y in span(a.y, b.y, c.y, top, top + rows) {
        for x in span(a.x, b.x, c.x, 0, field.width) {
            let (dx, dy) = (x as f32 + 0.5 - a.x, y as f32 + 0.5 - a.y);
            let (wb, wc) = ((dx * vy - dy * vx) * scale, (ux * dy - uy * dx) * scale);
            let weights = [1.0 - wb - wc, wb, wc];
            if !weights.iter().all(|&weight| weight >= -INSIDE) {
                continue;
            }
            let pixel = field.pixel(x, y);
            if !source.surfaces.is_receiver(pixel) {
                continue;
            }
            let patch = source.surfaces.patch(pixel);
            let (mut sum, mut total) = (0.0, 0.0);
            let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
            for corner in 0..3 {
                let same =
                    source.surfaces.agreement(&patch, patches[corner].position, patches[corner].normal);
                // A corner of zero weight must not be the only one left.
                let weight = weights[corner].max(INSIDE) * same * trust[corner];
                if weight > 0.0 {
                    sum += weight * values[corner];
                    total += weight;
                    low = low.min(values[corner]);
                    high = high.max(values[corner]);
                }
            }
            // Almost all of the triangle is on another surface: the RBF of the surrounding samples is better.
            if total > 10.0 * INSIDE {
                pixels[pixel - (top * field.width) as usize] = (sum / total).max(low).min(high);
            }
        }
    }
}
