//! Samples in the neighbourhood of a piece of a cell.

use halflight_core::fragment::Cell;
use halflight_core::glam::Vec3;

use rayon::prelude::*;

use super::cells::{Field, Piece, Rect};
use super::surface::{Patch, Surfaces};

/// Most samples that a piece of a cell uses; more distant ones are left out.
const MAX_SAMPLES: usize = 192;

/// Weight of a sample whose fragment lies on several surfaces: it only counts where there is no other.
const MIXED: f32 = 1e-4;

/// Sample with a defined value, and its surface.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Known {
    pub(super) x: f32,
    pub(super) y: f32,
    pub(super) value: f32,
    /// Inverse of the squared radius of influence, in pixels.
    pub(super) inverse_reach2: f32,
    /// Trust: 1 where the whole fragment lies on one surface, almost 0 where the value is a mixture.
    pub(super) trust: f32,
    pub(super) position: Vec3,
    pub(super) normal: Vec3,
    /// See [`Patch`].
    allowed: f32,
}

/// Influence of a sample, wherever it is used.
#[derive(Clone, Copy, Debug)]
pub(super) struct Role {
    /// Radius of influence, in pixels.
    reach: f32,
    /// See [`Known`].
    trust: f32,
}

/// Source of samples.
#[derive(Clone, Copy, Debug)]
pub(super) struct Source<'a> {
    pub(super) field: &'a Field<'a>,
    pub(super) surfaces: &'a Surfaces<'a>,
    /// Influence of every sample.
    pub(super) roles: &'a [Role],
}

impl Source<'_> {
    /// Trust in a sample, 0 … 1: the degree to which it belongs to one surface.
    pub(super) fn trust(&self, index: u32) -> f32 {
        self.roles[index as usize].trust
    }
}

/// Set of samples, with its memory.
#[derive(Debug)]
pub(super) struct Nearby {
    known: [Known; MAX_SAMPLES],
    indices: [u32; MAX_SAMPLES],
    len: usize,
}

impl Default for Nearby {
    fn default() -> Self {
        Self { known: [Known::default(); MAX_SAMPLES], indices: [0; MAX_SAMPLES], len: 0 }
    }
}

impl Nearby {
    pub(super) fn samples(&self) -> &[Known] {
        &self.known[..self.len]
    }

    /// Collects the samples of the piece's cell, and those of the cells around it whose influence reaches the
    /// piece.
    pub(super) fn gather(&mut self, source: &Source, piece: &Piece) {
        self.len = 0;
        let field = source.field;
        for &index in field.samples_of(piece.cell) {
            self.add(source, index, None);
        }
        field.walk_around(field.rect(piece.cell), 1, |cell| self.add_cell(source, cell, Some(piece.rect)));
    }

    /// Collects the samples of two wider rings of cells, whatever their influence.
    pub(super) fn gather_wide(&mut self, source: &Source, piece: &Piece) {
        self.len = 0;
        let field = source.field;
        self.add_cell(source, piece.cell, None);
        let size = 1 << piece.cell.level.min(15);
        for margin in [1, 2 + size, 4 + 2 * size] {
            field.walk_around(field.rect(piece.cell), margin, |cell| self.add_cell(source, cell, None));
        }
    }

    /// Least and largest value; `None` without samples.
    pub(super) fn bounds(&self) -> Option<(f32, f32)> {
        let first = self.samples().first()?.value;
        Some(
            self.samples()
                .iter()
                .fold((first, first), |(low, high), s| (low.min(s.value), high.max(s.value))),
        )
    }

    /// Surface of the first sample, if all samples lie so close to its plane that they fully agree with all
    /// points that do.
    pub(super) fn plane(&self, surfaces: &Surfaces) -> Option<Patch> {
        let first = self.samples().first()?;
        let plane = Patch { position: first.position, normal: first.normal, allowed: first.allowed };
        let flat = |known: &Known| surfaces.lies_on(&plane, known.position, known.normal, known.allowed);
        self.samples().iter().all(flat).then_some(plane)
    }

    /// Average for a pixel centred at (x, y) that shares a surface with none of the near samples: over the
    /// samples on its surface, weighted by distance; or else over all, weighted by the match of their
    /// surfaces. 0 without samples.
    pub(super) fn average(&self, surfaces: &Surfaces, x: f32, y: f32, patch: &Patch) -> f32 {
        let mean = |likeness: &dyn Fn(&Known) -> f32| {
            let (mut sum, mut total) = (0.0, 0.0);
            let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
            for known in self.samples() {
                let (dx, dy) = (known.x - x, known.y - y);
                let weight = likeness(known) / (dx * dx + dy * dy + 0.25);
                if weight > 0.0 {
                    sum += weight * known.value;
                    total += weight;
                    low = low.min(known.value);
                    high = high.max(known.value);
                }
            }
            (total > 0.0).then(|| (sum / total).clamp(low, high))
        };
        // Fit of a mixture: 1/2, since one that may contain the pixel's own surface is better than a pure
        // sample of another.
        let fit = |known: &Known| match known.trust < 0.5 {
            true => 0.5,
            false => surfaces.likeness(patch, known.position, known.normal),
        };
        mean(&|known| known.trust * surfaces.agreement(patch, known.position, known.normal))
            .or_else(|| mean(&fit))
            .unwrap_or(0.0)
    }

    fn add_cell(&mut self, source: &Source, cell: &Cell, reached: Option<Rect>) {
        for &index in source.field.samples_of(cell) {
            self.add(source, index, reached);
        }
    }

    /// Adds a sample once, if its value is defined and its influence reaches `reached`.
    #[inline]
    fn add(&mut self, source: &Source, index: u32, reached: Option<Rect>) {
        let Some(sample) = source.field.sample(index) else { return };
        let Some(value) = source.field.value(index) else { return };
        let Role { reach, trust } = source.roles[index as usize];
        if let Some(rect) = reached {
            // Distance to the nearest pixel centre of the rectangle.
            let dx = (rect.x0 as f32 + 0.5 - sample.x).max(sample.x - rect.x1 as f32 + 0.5).max(0.0);
            let dy = (rect.y0 as f32 + 0.5 - sample.y).max(sample.y - rect.y1 as f32 + 0.5).max(0.0);
            if dx * dx + dy * dy >= reach * reach {
                return;
            }
        }
        if self.len == MAX_SAMPLES || self.indices[..self.len].contains(&index) {
            return;
        }
        let patch = source.surfaces.patch(sample.pixel as usize);
        self.known[self.len] = Known {
            x: sample.x,
            y: sample.y,
            value,
            inverse_reach2: 1.0 / (reach * reach),
            trust,
            position: patch.position,
            normal: patch.normal,
            allowed: patch.allowed,
        };
        self.indices[self.len] = index;
        self.len += 1;
    }
}

/// Computes the influence of every sample. Its reach is `radius` times the spacing of samples in the largest
/// cell that uses it: a cell with a single sample has a spacing of one cell, one with more samples half a
/// cell.
pub(super) fn assign_roles(field: &Field, surfaces: &Surfaces, radius: f32, roles: &mut Vec<Role>) {
    roles.clear();
    (0..field.sample_count() as u32)
        .into_par_iter()
        .map(|index| Role { reach: radius, trust: trust(field, surfaces, index) })
        .collect_into_vec(roles);
    for cell in field.cells() {
        let samples = field.samples_of(cell);
        let size = f32::from(cell.level.min(31)).exp2();
        let spacing = if samples.len() > 1 { (0.5 * size).max(1.0) } else { size };
        for &index in samples {
            if let Some(role) = roles.get_mut(index as usize) {
                role.reach = role.reach.max(radius * spacing);
            }
        }
    }
}

/// Degree to which a sample belongs to one surface. The value of a fragment across an edge is a mixture that
/// is right on neither side: refinement by depth stops at 2×2 pixels, so such fragments are common at
/// silhouettes.
fn trust(field: &Field, surfaces: &Surfaces, index: u32) -> f32 {
    let Some(sample) = field.sample(index).filter(|sample| sample.level > 0) else { return 1.0 };
    let patch = surfaces.patch(sample.pixel as usize);
    let quarter = 0.25 * f32::from(sample.level.min(31)).exp2();
    let mut agreement = 1.0f32;
    for (dx, dy) in [(-quarter, -quarter), (quarter, -quarter), (-quarter, quarter), (quarter, quarter)] {
        let x = ((sample.x + dx).max(0.0) as u32).min(field.width - 1);
        let y = ((sample.y + dy).max(0.0) as u32).min(field.height - 1);
        let pixel = field.pixel(x, y);
        if surfaces.is_receiver(pixel) {
            let other = surfaces.patch(pixel);
            agreement = agreement.min(surfaces.agreement(&patch, other.position, other.normal));
        }
    }
    agreement.max(MIXED)
}
