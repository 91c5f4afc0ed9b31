//! The samples around a piece of a cell.

use halflight_core::fragment::Cell;
use halflight_core::glam::Vec3;

use super::cells::{Field, Piece, Rect};
use super::surface::{Patch, Surfaces};

/// Samples that a piece of a cell looks at; further ones are left out.
const MAX_SAMPLES: usize = 192;

/// A sample whose value exists, with its surface.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Known {
    pub(super) x: f32,
    pub(super) y: f32,
    pub(super) value: f32,
    /// One over the squared radius of its influence, in pixels.
    pub(super) inverse_reach2: f32,
    pub(super) position: Vec3,
    pub(super) normal: Vec3,
    index: u32,
}

/// Where samples are taken from.
#[derive(Clone, Copy, Debug)]
pub(super) struct Source<'a> {
    pub(super) field: &'a Field<'a>,
    pub(super) surfaces: &'a Surfaces<'a>,
    /// Radius of influence of every sample, in pixels.
    pub(super) reach: &'a [f32],
}

/// Samples, each once. Its memory is part of it.
#[derive(Debug)]
pub(super) struct Nearby {
    known: [Known; MAX_SAMPLES],
    len: usize,
}

impl Default for Nearby {
    fn default() -> Self {
        Self { known: [Known::default(); MAX_SAMPLES], len: 0 }
    }
}

impl Nearby {
    pub(super) fn samples(&self) -> &[Known] {
        &self.known[..self.len]
    }

    /// The samples of the piece's cell, and those of the cells around it whose influence reaches the piece.
    pub(super) fn gather(&mut self, source: &Source, piece: &Piece) {
        self.len = 0;
        let field = source.field;
        for &index in field.samples_of(piece.cell) {
            self.add(source, index, None);
        }
        field.walk_around(field.rect(piece.cell), 1, |cell| self.add_cell(source, cell, Some(piece.rect)));
    }

    /// The samples of two wider rings of cells, whatever their influence.
    pub(super) fn gather_wide(&mut self, source: &Source, piece: &Piece) {
        self.len = 0;
        let field = source.field;
        self.add_cell(source, piece.cell, None);
        let size = 1 << piece.cell.level.min(15);
        for margin in [1, 2 + size, 4 + 2 * size] {
            field.walk_around(field.rect(piece.cell), margin, |cell| self.add_cell(source, cell, None));
        }
    }

    /// The least and the largest value; `None` without samples.
    pub(super) fn bounds(&self) -> Option<(f32, f32)> {
        let first = self.samples().first()?.value;
        Some(
            self.samples()
                .iter()
                .fold((first, first), |(low, high), s| (low.min(s.value), high.max(s.value))),
        )
    }

    /// An average for a pixel centred at (x, y) that no near sample shares a surface with: of the samples that do, by
    /// distance; or else of all, by how well their surfaces fit. 0 without samples.
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
        mean(&|known| surfaces.agreement(patch, known.position, known.normal))
            .or_else(|| mean(&|known| surfaces.likeness(patch, known.position, known.normal)))
            .unwrap_or(0.0)
    }

    fn add_cell(&mut self, source: &Source, cell: &Cell, reached: Option<Rect>) {
        for &index in source.field.samples_of(cell) {
            self.add(source, index, reached);
        }
    }

    /// Adds a sample once, if its value exists and its influence reaches `reached`.
    #[inline]
    fn add(&mut self, source: &Source, index: u32, reached: Option<Rect>) {
        let Some(sample) = source.field.sample(index) else { return };
        let Some(value) = source.field.value(index) else { return };
        let reach = source.reach[index as usize];
        if let Some(rect) = reached {
            // From the nearest pixel centre of the rectangle.
            let dx = (rect.x0 as f32 + 0.5 - sample.x).max(sample.x - rect.x1 as f32 + 0.5).max(0.0);
            let dy = (rect.y0 as f32 + 0.5 - sample.y).max(sample.y - rect.y1 as f32 + 0.5).max(0.0);
            if dx * dx + dy * dy >= reach * reach {
                return;
            }
        }
        if self.len == MAX_SAMPLES || self.samples().iter().any(|known| known.index == index) {
            return;
        }
        let patch = source.surfaces.patch(sample.pixel as usize);
        self.known[self.len] = Known {
            x: sample.x,
            y: sample.y,
            value,
            inverse_reach2: 1.0 / (reach * reach),
            position: patch.position,
            normal: patch.normal,
            index,
        };
        self.len += 1;
    }
}

/// Writes the radius of influence of every sample: `radius` times the spacing of samples in the largest cell that uses
/// it. A cell with a sample of its own alone has them a cell apart, one with more half a cell.
pub(super) fn fill_reach(field: &Field, radius: f32, reach: &mut Vec<f32>) {
    reach.clear();
    reach.resize(field.sample_count(), radius);
    for cell in field.cells() {
        let samples = field.samples_of(cell);
        let size = f32::from(cell.level.min(31)).exp2();
        let spacing = if samples.len() > 1 { (0.5 * size).max(1.0) } else { size };
        for &index in samples {
            if let Some(reach) = reach.get_mut(index as usize) {
                *reach = reach.max(radius * spacing);
            }
        }
    }
}
