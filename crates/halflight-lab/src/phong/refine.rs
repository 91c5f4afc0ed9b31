//! Fragments of the pass: level by level, coarsest first (Nichols10, §3.2.1 and §3.4).

use glam::Vec3;
use halflight_core::fragment::{Fragments, LEVELS, Sample};
use halflight_core::gbuffer::GBuffer;
use halflight_core::pyramid::PyramidLevel;
use halflight_core::values::NO_VALUE;
use rayon::prelude::*;

use super::config::{LobeVisibility, PhongConfig};
use super::gather::{Gathered, Grid, Light};
use super::variance::blurred;
use super::{DISCARDED, NOT_RENDERED, Surfaces};

/// Fragments of one light and their values.
pub(super) struct Refined {
    pub(super) fragments: Fragments,
    /// Values of the samples, over radiance and reflectance.
    pub(super) values: Vec<Vec3>,
    /// Fragments gathered at each level.
    pub(super) rendered: [u64; LEVELS],
    /// Level of each pixel.
    pub(super) levels: Vec<u8>,
    pub(super) sampled: u64,
    pub(super) rays: u64,
}

/// Fragment that is gathered.
#[derive(Clone, Copy)]
struct Cell {
    x: u32,
    y: u32,
    pixel: usize,
}

/// Fate of a cell.
enum Verdict {
    /// Sees nothing.
    Empty,
    Split,
    /// Kept without a value: pixel, and level to show.
    Unlit(usize, u8),
    Render(usize),
}

/// No fragment.
const NONE: u32 = u32::MAX;

/// Chooses and gathers the fragments of a light.
pub(super) fn refine(surfaces: &Surfaces, light: &Light, config: &PhongConfig) -> Refined {
    let GBuffer { width, height, .. } = surfaces.gbuffer;
    let mut out = Refined {
        fragments: Fragments::default(),
        values: Vec::new(),
        rendered: [0; LEVELS],
        levels: vec![NOT_RENDERED; surfaces.gbuffer.pixels()],
        sampled: 0,
        rays: 0,
    };
    out.fragments.reset(width, height, 0);
    let coarsest = config.coarsest_level;
    let mut pending: Vec<(u32, u32)> = (0..height.div_ceil(1 << coarsest))
        .flat_map(|y| (0..width.div_ceil(1 << coarsest)).map(move |x| (x, y)))
        .collect();
    let mut brightest = 0.0f32;
    for level in (0..=coarsest).rev() {
        let mut next = Vec::new();
        let mut cells = Vec::new();
        let verdicts: Vec<Verdict> =
            pending.par_iter().map(|&(x, y)| classify(surfaces, light, config, level, x, y)).collect();
        for (&(x, y), verdict) in pending.iter().zip(verdicts) {
            match verdict {
                Verdict::Empty => {}
                Verdict::Split => split(&mut next, x, y),
                Verdict::Unlit(pixel, code) => {
                    // Discarded fragments reflect nothing; matte ones have no value to be interpolated.
                    let value = if code == DISCARDED { Vec3::ZERO } else { Vec3::splat(NO_VALUE) };
                    out.keep(level, Cell { x, y, pixel }, value, code);
                }
                Verdict::Render(pixel) => cells.push(Cell { x, y, pixel }),
            }
        }
        let values = out.gather(light, config, level, &cells);
        if level == coarsest {
            brightest = values.iter().map(|value| value.max_element()).fold(0.0, f32::max);
        }
        let changes = changes(&cells, &values, width.div_ceil(1 << level), config.threshold, brightest);
        for ((cell, value), changes) in cells.iter().zip(values).zip(changes) {
            if level > 0 && changes {
                split(&mut next, cell.x, cell.y);
            } else {
                out.keep(level, *cell, value, level);
            }
        }
        pending = next;
    }
    out
}

impl Refined {
    fn keep(&mut self, level: u8, cell: Cell, value: Vec3, code: u8) {
        let (width, height) = (self.fragments.width(), self.fragments.height());
        let sample = Sample { probes: 0, ..Sample::of_pixel(cell.pixel as u32, width, level, 0, 0) };
        let sample = self.fragments.push_sample(sample);
        self.fragments.push_cell(level, cell.x, cell.y, &[sample]);
        self.values.push(value);
        let (x0, y0) = (cell.x << level, cell.y << level);
        for y in y0..(y0 + (1 << level)).min(height) {
            let row = (y * width) as usize;
            self.levels[row + x0 as usize..row + (x0 + (1 << level)).min(width) as usize].fill(code);
        }
    }

    /// Returns the values of fragments of one level.
    fn gather(&mut self, light: &Light, config: &PhongConfig, level: u8, cells: &[Cell]) -> Vec<Vec3> {
        let gathered: Vec<(Gathered, u64)> = cells
            .par_iter()
            .map(|cell| match light.lobe(cell.pixel) {
                Some((lobe, origin)) => {
                    light.gather(&lobe, origin, (cell.x & 1 | (cell.y & 1) << 1) as usize)
                }
                None => (Gathered::Value(Vec3::ZERO), 0),
            })
            .collect();
        self.rendered[usize::from(level)] += cells.len() as u64;
        self.rays += gathered.iter().map(|(_, rays)| rays).sum::<u64>();
        self.sampled +=
            gathered.iter().filter(|(found, _)| matches!(found, Gathered::Grid(_))).count() as u64;
        let grids = Places::new(cells, self.fragments.width().div_ceil(1 << level));
        let around = |cell: Cell| {
            let gathered = &gathered;
            grids.around(cell, config.blur).filter_map(move |index| match &gathered[index].0 {
                Gathered::Grid(grid) => Some(grid),
                Gathered::Value(_) => None,
            })
        };
        let value = |(cell, (found, _)): (&Cell, &(Gathered, u64))| match found {
            Gathered::Value(value) => *value,
            Gathered::Grid(Grid { light, parts }) => match config.visibility {
                LobeVisibility::Variance => {
                    let seen = blurred(around(*cell), parts.len(), config.least_variance);
                    light.iter().zip(seen).map(|(light, seen)| *light * seen).sum()
                }
                LobeVisibility::None | LobeVisibility::Binary => {
                    light.iter().zip(parts).filter(|(_, part)| **part >= 1.0).map(|(light, _)| *light).sum()
                }
            },
        };
        cells.par_iter().zip(&gathered).map(value).collect()
    }
}

/// Decides about a cell before anything is gathered.
fn classify(surfaces: &Surfaces, light: &Light, config: &PhongConfig, level: u8, x: u32, y: u32) -> Verdict {
    let gbuffer = &surfaces.gbuffer;
    let (x0, y0) = (x << level, y << level);
    let (x1, y1) = ((x0 + (1 << level)).min(gbuffer.width), (y0 + (1 << level)).min(gbuffer.height));
    let pixels = || (y0..y1).flat_map(move |y| (x0..x1).map(move |x| gbuffer.index(x, y)));
    let (middle_x, middle_y) = (x0 + (1 << level) / 2, y0 + (1 << level) / 2);
    let distance = |pixel: &usize| {
        let (x, y) = (*pixel as u32 % gbuffer.width, *pixel as u32 / gbuffer.width);
        x.abs_diff(middle_x).pow(2) + y.abs_diff(middle_y).pow(2)
    };
    let Some(pixel) = pixels().filter(|&pixel| gbuffer.is_receiver(pixel)).min_by_key(distance) else {
        return Verdict::Empty;
    };
    let material = |pixel: usize| {
        let specular = surfaces.specular(pixel);
        (!specular.is_matte()).then_some(specular.roughness)
    };
    let own = material(pixel);
    let mixed = pixels().any(|pixel| gbuffer.is_receiver(pixel) && material(pixel) != own);
    if level > 0 && (mixed || breaks(surfaces.pyramid.level(level), config, x, y)) {
        return Verdict::Split;
    }
    if own.is_none() {
        return Verdict::Unlit(pixel, NOT_RENDERED);
    }
    let misses = |pixel: usize| light.lobe(pixel).is_none_or(|(lobe, origin)| light.misses(&lobe, origin));
    let corners = [(x0, y0), (x1 - 1, y0), (x0, y1 - 1), (x1 - 1, y1 - 1)];
    if config.cull && misses(pixel) && corners.iter().all(|&(x, y)| misses(gbuffer.index(x, y))) {
        return Verdict::Unlit(pixel, DISCARDED);
    }
    if level > 0 && config.spacing > 0.0 && shift(surfaces, light, pixel, level) > config.spacing {
        return Verdict::Split;
    }
    Verdict::Render(pixel)
}

/// Returns whether geometry splits a cell.
fn breaks(level: Option<&PyramidLevel>, config: &PhongConfig, x: u32, y: u32) -> bool {
    level.is_some_and(|level| {
        let index = level.index(x, y);
        level.depth[index] > config.geometry.depth || level.curvature[index] > config.geometry.curvature
    })
}

/// Returns by how many widths of the lobe it shifts over the light from one fragment of a level to the next, on a flat surface.
fn shift(surfaces: &Surfaces, light: &Light, pixel: usize, level: u8) -> f32 {
    let (Some((lobe, origin)), gbuffer) = (light.lobe(pixel), &surfaces.gbuffer) else { return 0.0 };
    let camera = &surfaces.scene.scene().camera;
    let from = gbuffer.position[pixel] - camera.eye;
    let (distance, (width, reach)) = (from.length(), light.width(&lobe, origin));
    let pixel_size = 2.0 * (0.5 * camera.fov_y_deg.to_radians()).tan() / gbuffer.height as f32;
    let slant = (gbuffer.normal[pixel].dot(from) / distance.max(f32::MIN_POSITIVE)).abs().max(0.05);
    let spacing = (1u32 << level) as f32 * pixel_size * gbuffer.depth[pixel] / slant;
    // The mirrored ray starts farther on and, since the view has turned, leaves in another direction.
    spacing * (1.0 + reach / distance.max(f32::MIN_POSITIVE)) / width.max(f32::MIN_POSITIVE)
}

fn split(next: &mut Vec<(u32, u32)>, x: u32, y: u32) {
    next.extend((0..4).map(|child| (2 * x + (child & 1), 2 * y + (child >> 1))));
}

/// Returns for each fragment whether its value changes from those around it by more than the threshold.
fn changes(
    cells: &[Cell],
    values: &[Vec3],
    columns: u32,
    threshold: Option<f32>,
    brightest: f32,
) -> Vec<bool> {
    let Some(threshold) = threshold else { return vec![false; cells.len()] };
    let places = Places::new(cells, columns);
    let changes = |cell: &Cell| {
        let found = places.around(*cell, 1).map(|index| values[index].max_element());
        let (low, high) =
            found.fold((f32::INFINITY, 0.0f32), |(low, high), value| (low.min(value), high.max(value)));
        high - low > threshold * brightest
    };
    cells.iter().map(changes).collect()
}

/// Fragments of a level by their places.
struct Places {
    columns: u32,
    indices: Vec<u32>,
}

impl Places {
    fn new(cells: &[Cell], columns: u32) -> Self {
        let rows = cells.iter().map(|cell| cell.y + 1).max().unwrap_or(0);
        let mut indices = vec![NONE; columns as usize * rows as usize];
        for (index, cell) in (0..).zip(cells) {
            indices[(cell.y * columns + cell.x) as usize] = index;
        }
        Self { columns, indices }
    }

    /// Indices of the fragments up to `radius` places from a cell, its own among them.
    fn around(&self, cell: Cell, radius: u32) -> impl Iterator<Item = usize> + '_ {
        let rows = self.indices.len() as u32 / self.columns.max(1);
        let columns = cell.x.saturating_sub(radius)..(cell.x + radius + 1).min(self.columns);
        (cell.y.saturating_sub(radius)..(cell.y + radius + 1).min(rows)).flat_map(move |y| {
            columns.clone().filter_map(move |x| {
                let index = self.indices[(y * self.columns + x) as usize];
                (index != NONE).then_some(index as usize)
            })
        })
    }
}
