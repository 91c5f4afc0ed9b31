//! Light propagation volume: Koa16 §3.2 on the scheme of Kaplanyan and Dachsbacher 2010 (Cascaded Light Propagation Volumes for Real-Time Indirect
//! Illumination, §3 to §5).
//!
//! 1. Lit points deposit what they reflect in the cell in front of them, as intensity in four spherical harmonics a channel (`grid`).
//! 2. Cells pass flux on to their six neighbours, step by step; all steps are summed (`propagate`).
//! 3. Pixels look up the sum, trilinearly, against the cosine lobe of their shading normal.

mod grid;
mod propagate;
#[cfg(test)]
mod tests;

use std::time::Instant;

use glam::Vec3;
use halflight_core::pattern::Pattern;
use halflight_core::stats::IndirectCounts;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::lit::Lit;
use super::points::Points;
use super::{Indirect, MOST_POINTS, Surroundings, light_points, milliseconds};
use grid::{Blocking, Grid, Volume};

/// Conversion of what points deposit in a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LpvNormalization {
    /// Flux: every point counts with the area that it stands for, so that the brightness does not depend on the grid.
    #[default]
    Area,
    /// Mean over the points of the cell (Koa16 §3.2), as if they were one wall across it.
    Points,
}

/// Options of [`Lpv`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LpvConfig {
    /// Cells along the longest side of the scene, about, 4 … 128: 32 (Kaplanyan and Dachsbacher 2010 §7). Their size is a power of the fourth root of
    /// 2, and the grid begins at a multiple of it, so that neither changes with small motions.
    pub cells: u32,
    /// Steps of propagation, 0 … 256: 8 (Kaplanyan and Dachsbacher 2010 §7).
    pub steps: u32,
    /// True if surfaces block the light that passes from cell to cell (§4.3 there, "fuzzy blocking"): true.
    pub blocking: bool,
    /// Points on the surfaces, about, 1 … 1,048,576: 8192.
    pub points: u32,
    /// Light samples of each point and light, 1 … 4096: 16.
    pub light_samples: u32,
    /// Distance by which points are moved along their normals before they deposit light, in cells: 0.5.
    pub offset: f32,
    /// Conversion of what points deposit: `area`.
    pub normalization: LpvNormalization,
}

impl Default for LpvConfig {
    fn default() -> Self {
        Self {
            cells: 32,
            steps: 8,
            blocking: true,
            points: 8192,
            light_samples: 16,
            offset: 0.5,
            normalization: LpvNormalization::Area,
        }
    }
}

/// Indirect light by a light propagation volume.
#[derive(Default)]
pub struct Lpv {
    config: LpvConfig,
    points: Points,
    lit: Lit,
    current: Volume,
    next: Volume,
    sum: Volume,
    blocking: Blocking,
    counts: Vec<u32>,
}

impl Lpv {
    /// Creates the stage. Numbers out of range are taken as the nearest that are in it.
    pub fn new(config: LpvConfig) -> Self {
        let config = LpvConfig {
            cells: config.cells.clamp(4, 128),
            steps: config.steps.min(256),
            points: config.points.clamp(1, MOST_POINTS),
            light_samples: config.light_samples.clamp(1, 4096),
            // NaN is no distance.
            offset: if config.offset > 0.0 { config.offset.min(2.0) } else { 0.0 },
            ..config
        };
        Self { config, ..Self::default() }
    }

    /// Deposits, propagates and sums the light of the points that are lit.
    fn fill(&mut self, grid: &Grid) {
        let Self { config, points, lit, current, next, sum, blocking, counts } = self;
        for volume in [&mut *current, &mut *next, &mut *sum] {
            volume.reset(grid);
        }
        counts.clear();
        counts.resize(grid.len(), 0);
        for emitter in &lit.emitters {
            let Some(cell) = grid.cell(emitter.origin + emitter.normal * (config.offset * grid.size)) else {
                continue;
            };
            let area = match config.normalization {
                LpvNormalization::Area => emitter.area,
                LpvNormalization::Points => grid.size * grid.size,
            };
            current.deposit(cell, emitter.radiosity * area, emitter.normal);
            counts[cell] += 1;
        }
        if config.normalization == LpvNormalization::Points {
            current.divide(counts);
        }
        sum.add(current);
        if config.blocking {
            blocking.fill(grid, points);
        }
        let blocking = config.blocking.then_some(&*blocking);
        for _ in 0..config.steps {
            propagate::step(grid, current, blocking, next);
            std::mem::swap(current, next);
            sum.add(current);
        }
    }
}

impl Indirect for Lpv {
    fn light(&mut self, surroundings: &mut Surroundings, out: &mut [Vec3]) -> IndirectCounts {
        let (config, frame) = (self.config, surroundings.frame);
        let mut counts =
            light_points(surroundings, &mut self.points, &mut self.lit, config.points, config.light_samples);
        out.fill(Vec3::ZERO);
        let grid = frame.scene.mesh.bounds().and_then(|(low, high)| Grid::new(low, high, config.cells));
        let Some(grid) = grid.filter(|_| !self.lit.emitters.is_empty()) else { return counts };
        let clock = Instant::now();
        self.fill(&grid);
        counts.transport_ms = milliseconds(clock);
        let clock = Instant::now();
        let (gbuffer, sum) = (frame.gbuffer, &self.sum);
        let normals = gbuffer.shading_normals();
        out.par_iter_mut().enumerate().with_min_len(1024).for_each(|(pixel, out)| {
            if gbuffer.is_receiver(pixel) {
                let at = gbuffer.position[pixel] + gbuffer.normal[pixel] * (config.offset * grid.size);
                *out = sum.irradiance(&grid, at, normals[pixel]);
            }
        });
        counts.lookup_ms = milliseconds(clock);
        counts
    }

    fn patterns(&self, full: Pattern) -> Vec<Pattern> {
        Pattern::with_count(full.kind, self.config.light_samples as usize).into_iter().collect()
    }

    fn bytes(&self) -> usize {
        self.points.bytes()
            + self.lit.bytes()
            + self.current.bytes()
            + self.next.bytes()
            + self.sum.bytes()
            + self.blocking.bytes()
            + self.counts.capacity() * 4
    }
}
