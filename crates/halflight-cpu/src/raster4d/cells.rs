//! Framebuffer of 4D rasterization: the triangles that may hide the light from a receiver, found by their
//! projections (Wang17 §3.1, STEPs 2 to 4).

use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering};

use glam::Vec3;
use halflight_core::gbuffer::GBuffer;
use halflight_core::light::AreaLight;
use halflight_core::scene::Mesh;
use rayon::prelude::*;

use super::project::{Projection, Rectangle};
use crate::occluder::NOWHERE;

/// Most runs of triangles that are binned in parallel.
const MAX_RUNS: usize = 16;

/// Triangles of one cell, or of all: their rectangles and indices.
#[derive(Debug, Default)]
pub(super) struct Entries {
    pub(super) low: [Vec<f32>; 2],
    pub(super) high: [Vec<f32>; 2],
    pub(super) triangles: Vec<u32>,
}

impl Entries {
    pub(super) fn clear(&mut self) {
        self.low.iter_mut().chain(&mut self.high).for_each(Vec::clear);
        self.triangles.clear();
    }

    #[inline(always)]
    pub(super) fn push(&mut self, from: &Self, slot: usize) {
        for axis in 0..2 {
            self.low[axis].push(from.low[axis][slot]);
            self.high[axis].push(from.high[axis][slot]);
        }
        self.triangles.push(from.triangles[slot]);
    }
}

/// Cell of a level, and the first cell of a range on that level.
#[derive(Clone, Copy)]
pub(super) struct Place {
    level: usize,
    cell: [u16; 2],
    first: [u16; 2],
}

/// Triangles by cell for one side of a light. Several framebuffers form levels, each half the size of the one
/// before. A triangle is stored on the finest level on which its rectangle covers few cells, in all of these
/// cells.
#[derive(Debug)]
pub(super) struct Cells {
    projection: Projection,
    side: u32,
    low: [f32; 2],
    scale: [f32; 2],
    /// Index in `starts` of the first cell of each level.
    levels: Vec<usize>,
    starts: Vec<u32>,
    pub(super) entries: Entries,
    rectangles: Vec<Option<(Rectangle, u8, [u16; 4])>>,
    /// Write position of each run of triangles in every cell.
    places_of_runs: Vec<u32>,
    slots: Vec<AtomicU32>,
    /// Projected receivers from which the framebuffer's bounds are computed.
    places: [Vec<f32>; 2],
}

/// Number of sampled receivers, at either end of an axis, that the framebuffer's bounds leave out; they go to
/// its border cells.
const TAIL: usize = 200;

/// Stride in pixels with which receivers are sampled for the bounds.
const STRIDE: usize = 13;

impl Cells {
    pub(super) fn new(side: u32) -> Self {
        Self {
            projection: Projection::new(NOWHERE.frame(), false, 1.0),
            side,
            low: [0.0; 2],
            scale: [0.0; 2],
            levels: Vec::new(),
            starts: Vec::new(),
            entries: Entries::default(),
            rectangles: Vec::new(),
            places_of_runs: Vec::new(),
            slots: Vec::new(),
            places: Default::default(),
        }
    }

    /// Bins all triangles without an alpha mask for one side of a light. With `span`, a triangle goes to the finest level on which
    /// it covers at most that many cells per side; without, all go to the finest level.
    pub(super) fn fill(
        &mut self,
        mesh: &Mesh,
        gbuffer: &GBuffer,
        light: &AreaLight,
        back: bool,
        span: Option<u16>,
    ) {
        let corners = light.corners();
        let distances = mesh.positions.par_iter().with_min_len(4096).map(|p| p.distance(corners[0]));
        let reach = distances.reduce(|| 0.0, f32::max);
        let reach = f64::from(reach.max(corners.iter().map(|c| c.distance(corners[0])).fold(0.0, f32::max)));
        self.projection = Projection::new(light.frame(), back, reach * 1.001 + f64::from(f32::MIN_POSITIVE));
        self.frame(gbuffer);
        self.lay_out_levels(span.is_some());
        let mut rectangles = std::mem::take(&mut self.rectangles);
        let this = &*self;
        let range = |triangle: usize| {
            if mesh.alpha_mask(triangle).is_some() {
                return None;
            }
            let rectangle = this.projection.triangle(mesh.corners(triangle))?;
            let [x0, y0] = this.cell(rectangle.low);
            let [x1, y1] = this.cell(rectangle.high);
            let mut level = 0u8;
            while span.is_some_and(|span| {
                (x1 >> level) - (x0 >> level) >= span || (y1 >> level) - (y0 >> level) >= span
            }) {
                level += 1;
            }
            Some((rectangle, level, [x0 >> level, y0 >> level, x1 >> level, y1 >> level]))
        };
        (0..mesh.triangle_count())
            .into_par_iter()
            .with_min_len(1024)
            .map(range)
            .collect_into_vec(&mut rectangles);
        self.rectangles = rectangles;
        self.bin();
    }

    /// Counts, scans and fills. Several runs of triangles are processed in parallel, each with its own write
    /// position in every cell.
    fn bin(&mut self) {
        let Self { side, levels, rectangles, starts, places_of_runs, slots, entries, .. } = self;
        let cells = |level: u8, [x0, y0, x1, y1]: [u16; 4]| {
            let (first, width) = (levels[usize::from(level)], side.div_ceil(1 << level) as usize);
            (y0..=y1)
                .flat_map(move |y| (x0..=x1).map(move |x| first + usize::from(y) * width + usize::from(x)))
        };
        let count = starts.len() - 1;
        let runs = rayon::current_num_threads().clamp(1, MAX_RUNS);
        let size = rectangles.len().div_ceil(runs).max(1);
        places_of_runs.clear();
        places_of_runs.resize(runs * count, 0);
        places_of_runs.par_chunks_mut(count).zip(rectangles.par_chunks(size)).for_each(|(counts, run)| {
            for &(_, level, range) in run.iter().flatten() {
                for cell in cells(level, range) {
                    counts[cell] += 1;
                }
            }
        });
        let mut sum = 0;
        for cell in 0..count {
            starts[cell] = sum;
            for run in 0..runs {
                let place = &mut places_of_runs[run * count + cell];
                sum += std::mem::replace(place, sum);
            }
        }
        starts[count] = sum;
        // No two runs write to the same slot, and the result does not depend on the number of runs.
        let total = sum as usize;
        if slots.len() < total {
            slots.resize_with(total, AtomicU32::default);
        }
        let filled = &slots[..];
        places_of_runs.par_chunks_mut(count).zip(rectangles.par_chunks(size)).enumerate().for_each(
            |(number, (places, run))| {
                for (triangle, found) in (number * size..).zip(run) {
                    let Some((_, level, range)) = *found else { continue };
                    for cell in cells(level, range) {
                        filled[places[cell] as usize].store(triangle as u32, Ordering::Relaxed);
                        places[cell] += 1;
                    }
                }
            },
        );
        let filled = filled[..total].par_iter().with_min_len(4096);
        filled.map(|triangle| triangle.load(Ordering::Relaxed)).collect_into_vec(&mut entries.triangles);
        let rectangle = |&triangle: &u32| {
            rectangles[triangle as usize].map_or(Rectangle::EMPTY, |(rectangle, ..)| rectangle)
        };
        for axis in 0..2 {
            let triangles = || entries.triangles.par_iter().with_min_len(4096);
            triangles()
                .map(|triangle| rectangle(triangle).low[axis])
                .collect_into_vec(&mut entries.low[axis]);
            triangles()
                .map(|triangle| rectangle(triangle).high[axis])
                .collect_into_vec(&mut entries.high[axis]);
        }
    }

    /// Computes the bounds of the framebuffer from the receivers' projections through the light's corner.
    fn frame(&mut self, gbuffer: &GBuffer) {
        let mut places = std::mem::take(&mut self.places);
        places.iter_mut().for_each(Vec::clear);
        for pixel in (0..gbuffer.pixels()).step_by(STRIDE) {
            let receiver = gbuffer.receiver(pixel);
            if let Some((_, place)) = receiver.and_then(|receiver| self.projection.receiver(receiver.origin))
            {
                places[0].push(place[0]);
                places[1].push(place[1]);
            }
        }
        for (axis, places) in places.iter_mut().enumerate() {
            if places.is_empty() {
                (self.low[axis], self.scale[axis]) = (0.0, 0.0);
                continue;
            }
            let tail = places.len() / TAIL;
            let last = places.len() - 1 - tail;
            let low = *places.select_nth_unstable_by(tail, f32::total_cmp).1;
            let high = *places.select_nth_unstable_by(last, f32::total_cmp).1;
            let size = high - low;
            self.low[axis] = low;
            self.scale[axis] = if size > 0.0 { self.side as f32 / size } else { 0.0 };
        }
        self.places = places;
    }

    fn lay_out_levels(&mut self, several: bool) {
        self.levels.clear();
        let mut first = 0;
        for level in 0.. {
            let side = self.side.div_ceil(1 << level) as usize;
            self.levels.push(first);
            first += side * side;
            if side == 1 || !several {
                break;
            }
        }
        self.starts.clear();
        self.starts.resize(first + 1, 0);
    }

    /// Cell of the finest level at a position; positions outside belong to the border cells.
    fn cell(&self, place: [f32; 2]) -> [u16; 2] {
        let last = (self.side - 1) as f32;
        [0, 1].map(|axis| ((place[axis] - self.low[axis]) * self.scale[axis]).clamp(0.0, last) as u16)
    }

    /// Rectangle of a receiver and its cells on the finest level: the cell of its projection through the
    /// light's corner, or, if `all`, all cells that its rectangle covers. `None` where no list is guaranteed
    /// to be complete.
    pub(super) fn receiver(&self, point: Vec3, all: bool) -> Option<(Rectangle, [u16; 4])> {
        let (rectangle, place) = self.projection.receiver(point)?;
        let [x0, y0] = self.cell(if all { rectangle.low } else { place });
        let [x1, y1] = self.cell(if all { rectangle.high } else { place });
        Some((rectangle, [x0, y0, x1, y1]))
    }

    /// Entries of a range of cells that is given on the finest level: cell by cell, coarsest level first,
    /// each with its cell and the first cell of the range on its level.
    pub(super) fn lists(&self, [x0, y0, x1, y1]: [u16; 4]) -> impl Iterator<Item = (Range<usize>, Place)> {
        (0..self.levels.len()).rev().flat_map(move |level| {
            let (first, width) = (self.levels[level], self.side.div_ceil(1 << level) as usize);
            (y0 >> level..=y1 >> level).flat_map(move |y| {
                (x0 >> level..=x1 >> level).map(move |x| {
                    let cell = first + usize::from(y) * width + usize::from(x);
                    let list = self.starts[cell] as usize..self.starts[cell + 1] as usize;
                    (list, Place { level, cell: [x, y], first: [x0 >> level, y0 >> level] })
                })
            })
        })
    }

    /// True if a cell is the first of its range that contains the triangle of an entry.
    pub(super) fn is_first(&self, slot: usize, place: Place) -> bool {
        let start = self.cell([self.entries.low[0][slot], self.entries.low[1][slot]]);
        (0..2).all(|axis| place.cell[axis] == place.first[axis].max(start[axis] >> place.level))
    }

    /// Number of triangle entries of all cells.
    pub(super) fn entry_count(&self) -> usize {
        self.entries.triangles.len()
    }

    pub(super) fn bytes(&self) -> usize {
        (self.starts.capacity() + self.places_of_runs.capacity() + self.slots.capacity()) * 4
            + self.entries.triangles.capacity() * 20
            + self.rectangles.capacity() * size_of::<Option<(Rectangle, u8, [u16; 4])>>()
    }
}
