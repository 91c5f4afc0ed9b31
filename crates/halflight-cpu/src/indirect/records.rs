//! Receivers at which indirect light is gathered, and interpolation between them.
//!
//! Cells of the image are split from coarse to fine: where a surface ends or bends inside, down to a finest level, and where the light at their corners
//! differs, down to single pixels. Pixels take their light from the corners of their cell that lie on their surface; those without one from a receiver
//! nearby that is gathered for them.

use glam::Vec3;
use halflight_core::frame::Frame;
use halflight_core::gbuffer::GBuffer;
use rayon::prelude::*;

use super::Surroundings;
use super::gather::{Effort, Gathered, Receiver, Scratch, Sources};
use super::near::Near;
use crate::compose::luminance;
use crate::corners::Corners;
use crate::pool::Pool;
use crate::refine::discontinuities::Discontinuities;
use crate::refine::pixel_set::PixelSet;
use crate::tangent_plane::{Between, DiscontinuityLimits, TangentPlanes};

/// Marks pixels without a record, and pixels without a cell.
const NONE: u32 = u32::MAX;

/// Cosine between shading normals below which light is not taken over from one pixel to another.
const TURN: f32 = 0.94;

/// Part of the image's mean light below which differences count as those of the mean.
const DARK: f32 = 0.1;

/// Farthest pixel, in columns or rows, that a pixel without a corner takes its light from.
const REACH: u32 = 3;

/// Sizes of cells.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Levels {
    /// Cells of 2^level pixels that are begun with.
    pub(crate) coarsest: u8,
    /// Level down to which surfaces that end or bend split cells.
    pub(crate) finest: u8,
    /// Difference between the corners of a cell, relative to their mean, above which it is split.
    pub(crate) spread: f32,
}

/// Distance between corners, in distances of the light that arrives there, above which a cell is split.
const BETWEEN: f32 = 0.4;

/// Distance, in the same, up to which a pixel takes its light from a single receiver.
const BESIDE: f32 = 0.15;

/// Cell in units of cells of its level.
#[derive(Clone, Copy, Debug)]
struct Cell {
    level: u8,
    x: u32,
    y: u32,
}

/// Records of a frame, in buffers that are kept.
#[derive(Default)]
pub(crate) struct Records {
    discontinuities: Discontinuities,
    wanted: PixelSet,
    fresh: Vec<u32>,
    /// Record of each pixel.
    of_pixel: Vec<u32>,
    gathered: Vec<Gathered>,
    cells: Vec<Cell>,
    pending: Vec<Cell>,
    next: Vec<Cell>,
    /// Cell of each pixel.
    owners: Vec<u32>,
    /// Pixels without a corner on their surface, and the pixels whose records they take.
    sources: Vec<(u32, u32)>,
    pool: Pool<Scratch>,
    near: Near,
    /// Short rays, and shadow rays from what they hit.
    near_rays: u64,
}

/// Frame, its sources of indirect light, and what is spent on each receiver.
pub(crate) struct Task<'a> {
    pub(crate) frame: &'a Frame<'a>,
    pub(crate) sources: Sources<'a>,
    pub(crate) effort: Effort,
    pub(crate) levels: Levels,
    /// Short rays of each receiver with light from nearby.
    pub(crate) near_rays: usize,
    /// Key of the receivers' random numbers.
    pub(crate) key: u32,
}

impl Records {
    /// Gathers at as many receivers as the task's levels take.
    pub(crate) fn gather(&mut self, task: &Task, surroundings: &mut Surroundings) {
        self.near_rays = 0;
        let gbuffer = task.frame.gbuffer;
        let Levels { coarsest, finest, spread } = task.levels;
        // Discontinuities do not depend on the light.
        self.discontinuities.find(task.frame, 0, &DiscontinuityLimits::default(), TURN, coarsest);
        self.of_pixel.clear();
        self.of_pixel.resize(gbuffer.pixels(), NONE);
        self.gathered.clear();
        self.cells.clear();
        self.pending.clear();
        let (columns, rows) = (gbuffer.width.div_ceil(1 << coarsest), gbuffer.height.div_ceil(1 << coarsest));
        self.pending
            .extend((0..rows).flat_map(|y| (0..columns).map(move |x| Cell { level: coarsest, x, y })));
        for level in (0..=coarsest).rev() {
            self.descend(task, surroundings, level, finest, spread);
        }
        self.own(gbuffer);
    }

    /// Processes the pending cells of a level.
    fn descend(&mut self, task: &Task, surroundings: &mut Surroundings, level: u8, finest: u8, spread: f32) {
        let gbuffer = task.frame.gbuffer;
        let pending = std::mem::take(&mut self.pending);
        let mut next = std::mem::take(&mut self.next);
        self.wanted.reset(gbuffer.width, gbuffer.height);
        let mut kept = Vec::with_capacity(pending.len());
        for &cell in &pending {
            if cell.x << level >= gbuffer.width || cell.y << level >= gbuffer.height {
                continue;
            }
            let breaks = self.discontinuities.inside(level, cell.x, cell.y) != Between::Nothing;
            if breaks && level > finest {
                next.extend(quarters(cell));
                continue;
            }
            let corners = Corners::new(gbuffer.width, gbuffer.height, level, cell.x, cell.y);
            for ((x, y), pixel) in corners.positions().into_iter().zip(corners.pixels()) {
                if self.of_pixel[pixel] == NONE && gbuffer.is_receiver(pixel) {
                    self.wanted.insert(x, y);
                }
            }
            kept.push((cell, corners, breaks));
        }
        self.trace(task, surroundings);
        let planes = TangentPlanes::new(task.frame, &DiscontinuityLimits::default());
        let sum: f64 = self.gathered.iter().map(|gathered| f64::from(luminance(gathered.irradiance))).sum();
        let mean = (sum / self.gathered.len().max(1) as f64) as f32;
        for (cell, corners, breaks) in kept {
            if level > 0 && self.varies(gbuffer, &planes, &corners, breaks, spread, DARK * mean) {
                next.extend(quarters(cell));
            } else {
                self.cells.push(cell);
            }
        }
        self.pending = next;
        self.next = pending;
        self.next.clear();
    }

    /// True if the light of corners that lie together differs by more than a part of their mean, or comes from so near that it may differ between them.
    fn varies(
        &self,
        gbuffer: &GBuffer,
        planes: &TangentPlanes,
        corners: &Corners,
        breaks: bool,
        spread: f32,
        least: f32,
    ) -> bool {
        let (pixels, places) = (corners.pixels(), corners.positions());
        for a in 0..4 {
            let Some(one) = self.gathered.get(self.of_pixel[pixels[a]] as usize) else { continue };
            for b in 0..a {
                let Some(other) = self.gathered.get(self.of_pixel[pixels[b]] as usize) else { continue };
                let apart = places[a].0.abs_diff(places[b].0).max(places[a].1.abs_diff(places[b].1));
                // Surfaces apart differ anyway: their pixels take the corners of their own.
                if breaks && !lie_together(gbuffer, planes, pixels[a], pixels[b], apart) {
                    continue;
                }
                let (x, y) = (luminance(one.irradiance), luminance(other.irradiance));
                let between = gbuffer.position[pixels[a]].distance(gbuffer.position[pixels[b]]);
                if (x - y).abs() > spread * (0.5 * (x + y)).max(least)
                    || between > BETWEEN * one.distance().min(other.distance())
                {
                    return true;
                }
            }
        }
        false
    }

    /// Gathers at the wanted pixels.
    fn trace(&mut self, task: &Task, surroundings: &mut Surroundings) {
        let Self { wanted, fresh, of_pixel, gathered, pool, near, near_rays, .. } = self;
        wanted.drain(fresh);
        let first = gathered.len();
        for (index, &pixel) in fresh.iter().enumerate() {
            of_pixel[pixel as usize] = (first + index) as u32;
        }
        gathered.resize(first + fresh.len(), Gathered::NONE);
        let chunks = gathered[first..].par_chunks_mut(16).zip(fresh.par_chunks(16));
        chunks.for_each(|(out, pixels)| {
            pool.lend(Scratch::default, |scratch| {
                for (out, &pixel) in out.iter_mut().zip(pixels) {
                    *out = task.at(pixel, scratch);
                }
            });
        });
        if task.near_rays > 0 {
            let reach = task.sources.reach.sqrt();
            *near_rays += near.add(surroundings, reach, task.near_rays, fresh, &mut gathered[first..]);
        }
    }

    /// Finds the cell of every pixel.
    fn own(&mut self, gbuffer: &GBuffer) {
        let Self { owners, cells, .. } = self;
        let (width, height) = (gbuffer.width, gbuffer.height);
        owners.clear();
        owners.resize(gbuffer.pixels(), NONE);
        for (index, cell) in cells.iter().enumerate() {
            let (x0, y0) = (cell.x << cell.level, cell.y << cell.level);
            let (x1, y1) = ((x0 + (1 << cell.level)).min(width), (y0 + (1 << cell.level)).min(height));
            for y in y0..y1 {
                let row = (y * width) as usize;
                owners[row + x0 as usize..row + x1 as usize].fill(index as u32);
            }
        }
    }

    /// Writes the light of every pixel, and gathers where no corner lies on a pixel's surface.
    pub(crate) fn interpolate(&mut self, task: &Task, surroundings: &mut Surroundings, out: &mut [Vec3]) {
        let gbuffer = task.frame.gbuffer;
        let planes = TangentPlanes::new(task.frame, &DiscontinuityLimits::default());
        let width = gbuffer.width.max(1) as usize;
        self.wanted.reset(gbuffer.width, gbuffer.height);
        out.par_chunks_mut(width).enumerate().for_each(|(y, out)| {
            for (x, out) in out.iter_mut().enumerate() {
                let pixel = y * width + x;
                *out = Vec3::ZERO;
                if !gbuffer.is_receiver(pixel) {
                    continue;
                }
                match self.between_corners(gbuffer, &planes, x as u32, y as u32) {
                    Some(light) => *out = light,
                    None => self.wanted.insert(x as u32, y as u32),
                }
            }
        });
        self.fill(task, surroundings, &planes, out);
    }

    /// Light between the corners of a pixel's cell, if one of them lies on its surface.
    fn between_corners(&self, gbuffer: &GBuffer, planes: &TangentPlanes, x: u32, y: u32) -> Option<Vec3> {
        let pixel = (y * gbuffer.width + x) as usize;
        if let Some(own) = self.gathered.get(self.of_pixel[pixel] as usize) {
            return Some(own.irradiance);
        }
        let cell = self.cells.get(self.owners[pixel] as usize)?;
        let corners = Corners::new(gbuffer.width, gbuffer.height, cell.level, cell.x, cell.y);
        let weights = corners.weights(x, y);
        let (mut sum, mut total) = (Vec3::ZERO, 0.0);
        let (mut near, mut near_total) = (Vec3::ZERO, 0.0);
        for (corner, (weight, (cx, cy))) in
            corners.pixels().into_iter().zip(weights.into_iter().zip(corners.positions()))
        {
            let Some(record) = self.gathered.get(self.of_pixel[corner] as usize) else { continue };
            let apart = cx.abs_diff(x).max(cy.abs_diff(y));
            if weight > 0.0 && lie_together(gbuffer, planes, pixel, corner, apart) {
                sum += record.irradiance * weight;
                total += weight;
                if is_beside(gbuffer, pixel, corner, apart, record) {
                    near += record.irradiance * weight;
                    near_total += weight;
                }
            }
        }
        // Between all corners; or beside some of them, though not far from them all.
        if total > 0.999 {
            return Some(sum / total);
        }
        (near_total > 0.05).then(|| near / near_total)
    }

    /// Gathers for the pixels that no corner serves: the first of those that lie together, for all of them.
    fn fill(
        &mut self,
        task: &Task,
        surroundings: &mut Surroundings,
        planes: &TangentPlanes,
        out: &mut [Vec3],
    ) {
        let gbuffer = task.frame.gbuffer;
        let width = gbuffer.width;
        self.wanted.drain(&mut self.fresh);
        if self.fresh.is_empty() {
            return;
        }
        let tile = |pixel: u32| (pixel / width / 8, pixel % width / 8);
        let tiles: Vec<&[u32]> = self.fresh.chunk_by(|&a, &b| tile(a) == tile(b)).collect();
        let chosen: Vec<Vec<(u32, u32)>> = tiles
            .par_iter()
            .with_min_len(16)
            .map(|pixels| {
                let mut sources: Vec<(u32, u32)> = Vec::with_capacity(pixels.len());
                for &pixel in *pixels {
                    let (x, y) = (pixel % width, pixel / width);
                    let serves = |&&(own, source): &&(u32, u32)| {
                        let apart = (source % width).abs_diff(x).max((source / width).abs_diff(y));
                        own == source
                            && apart <= REACH
                            && lie_together(gbuffer, planes, pixel as usize, source as usize, apart)
                    };
                    let source = sources.iter().find(serves).map_or(pixel, |&(_, source)| source);
                    sources.push((pixel, source));
                }
                sources
            })
            .collect();
        self.sources.clear();
        self.sources.extend(chosen.into_iter().flatten());
        for &(pixel, source) in &self.sources {
            if pixel == source {
                self.wanted.insert(pixel % width, pixel / width);
            }
        }
        self.trace(task, surroundings);
        for &(pixel, source) in &self.sources {
            let record = self.of_pixel[source as usize] as usize;
            out[pixel as usize] = self.gathered[record].irradiance;
        }
    }

    /// Number of receivers, and of shadow rays from them.
    pub(crate) fn counts(&self) -> (u64, u64) {
        let rays: u64 = self.gathered.iter().map(|gathered| u64::from(gathered.rays)).sum();
        (self.gathered.len() as u64, rays + self.near_rays)
    }

    /// Memory held, bytes.
    pub(crate) fn bytes(&self) -> usize {
        let cells = self.cells.capacity() + self.pending.capacity() + self.next.capacity();
        self.discontinuities.bytes()
            + self.near.bytes()
            + self.wanted.bytes()
            + (self.fresh.capacity() + self.of_pixel.capacity() + self.owners.capacity()) * 4
            + self.gathered.capacity() * size_of::<Gathered>()
            + cells * size_of::<Cell>()
            + self.sources.capacity() * size_of::<(u32, u32)>()
    }
}

impl Task<'_> {
    /// Light at a pixel.
    fn at(&self, pixel: u32, scratch: &mut Scratch) -> Gathered {
        let gbuffer = self.frame.gbuffer;
        let index = pixel as usize;
        let receiver = Receiver {
            origin: gbuffer.position[index],
            normal: gbuffer.normal[index],
            shading: gbuffer.shading_normals()[index],
        };
        let key = halflight_core::hash::fold(self.key, pixel);
        let (a, b) = halflight_core::hash::unit_pair(key);
        self.sources.gather(&receiver, self.effort, [a, b], scratch)
    }
}

/// True if light may be taken over from one pixel to another that lies `apart` columns or rows away.
fn lie_together(gbuffer: &GBuffer, planes: &TangentPlanes, a: usize, b: usize, apart: u32) -> bool {
    let normals = gbuffer.shading_normals();
    !planes.is_discontinuity(a, b, apart) && normals[a].dot(normals[b]) > TURN
}

/// True if a pixel, `apart` columns or rows from a receiver, is so near to it for the distance that light comes from that it has the same light.
fn is_beside(gbuffer: &GBuffer, pixel: usize, at: usize, apart: u32, record: &Gathered) -> bool {
    let distance = record.distance();
    // Of a dark receiver it is not known from where light may come.
    if distance.is_infinite() {
        return apart <= 1;
    }
    gbuffer.position[pixel].distance(gbuffer.position[at]) <= BESIDE * distance
}

fn quarters(cell: Cell) -> impl Iterator<Item = Cell> {
    (0..4).map(move |child| Cell {
        level: cell.level - 1,
        x: 2 * cell.x + (child & 1),
        y: 2 * cell.y + (child >> 1),
    })
}
