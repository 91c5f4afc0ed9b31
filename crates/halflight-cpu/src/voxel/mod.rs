//! The `voxel` visibility backend: rays marched through a coarse bit grid over the view frustum (Nichols10
//! §3.3).
//!
//! [`prepare`](Visibility::prepare) rasterizes every triangle into the grid once per frame (`rasterize`).
//! Batches march their rays through it (`march`), except for those parts of the way to the light where the
//! grid is empty for all samples (`fan`). Masks are approximate: [`error_map`] tells where and why they
//! differ from exact ones. Geometry outside the grid, out of view, casts no shadow.

mod config;
pub mod error_map;
mod fan;
mod frustum;
mod grid;
mod march;
mod rasterize;
mod run;
#[cfg(test)]
mod tests;

use glam::Vec3;
use halflight_core::frame::Frame;
use halflight_core::light::AreaLight;
use halflight_core::mask::{MaskBatch, Query};
use halflight_core::pattern::Pattern;
use halflight_core::stages::{UnsupportedLight, Visibility};
use rayon::prelude::*;

pub use config::{Traversal, VoxelConfig, VoxelError};
pub use frustum::Frustum;
pub use march::turned;

use crate::pool::TASK;
use crate::samples::{LANES, positions};
use crate::simd::{Isa, Kernel, Simd};
use grid::Grid;
use march::{Measures, Rays};
use run::Run;

/// Number of queries that one task answers.
const CHUNK: usize = 64;

/// Approximate visibility by voxel marching.
#[derive(Debug)]
pub struct Voxels {
    config: VoxelConfig,
    grid: Grid,
    /// Frustum of the grid; `None` before the first frame and where no pixel sees geometry.
    frustum: Option<Frustum>,
    isa: Isa,
}

impl Voxels {
    /// Creates a backend with an empty grid.
    ///
    /// # Errors
    /// An error if an option is out of range.
    pub fn new(config: VoxelConfig) -> Result<Self, VoxelError> {
        config.validate()?;
        let grid = Grid::new(config.resolution as usize, config.depth_bits as usize);
        Ok(Self { config, grid, frustum: None, isa: Isa::best() })
    }

    /// Options of the backend.
    pub fn config(&self) -> VoxelConfig {
        self.config
    }

    /// Frustum of the grid; `None` before the first frame and where no pixel sees geometry.
    pub fn frustum(&self) -> Option<&Frustum> {
        self.frustum.as_ref()
    }

    /// All voxels, one bit each: texels row by row, slices in words from the nearest on, the lowest bit
    /// first.
    pub fn words(&self) -> Vec<u64> {
        self.grid.to_words()
    }

    /// Selects another instruction set; the masks are identical. For comparison.
    #[must_use]
    pub fn with_isa(self, isa: Isa) -> Self {
        Self { isa, ..self }
    }

    /// Data that rays to a light share, or `None` where nothing can stop any ray.
    fn course(&self, light: &AreaLight) -> Option<Course<'_>> {
        let frustum = self.frustum.as_ref()?;
        let normal = light.normal();
        let corners = light.corners();
        let middle = (corners[0] + corners[2]) * 0.5;
        let points = corners.into_iter().chain([middle]);
        let width = points
            .filter(|&point| frustum.holds(frustum.place(point)))
            .map(|point| frustum.width_along(point, normal))
            .fold(0.0, f32::max);
        Some(Course {
            grid: &self.grid,
            frustum,
            measures: Measures::new(frustum),
            config: self.config,
            light: turned(frustum, light),
            place: corners[0],
            normal,
            turned_normal: frustum.turn(normal.as_dvec3()).as_vec3(),
            clearance: width * self.config.bias,
        })
    }
}

impl Visibility for Voxels {
    fn masks(&mut self, frame: &Frame, batch: &mut MaskBatch) {
        let (pattern, words) = (batch.pattern(), batch.words());
        let light = *frame.light(batch.light());
        let parts = batch.parts();
        if words == 0 {
            return;
        }
        if self.frustum.is_none() {
            parts.visible.copy_from_slice(parts.wanted);
            return;
        }
        if light.as_sphere().is_some() {
            let masks = parts.wanted.par_chunks(words).zip(parts.visible.par_chunks_mut(words));
            parts.queries.par_iter().zip(masks).with_min_len(CHUNK).for_each(|(query, (wanted, visible))| {
                let queries = std::slice::from_ref(query);
                if let Some(course) = self.course(&light.seen_from(query.origin)) {
                    self.isa.run(Chunk { course: &course, pattern, words, queries, wanted, visible });
                }
            });
            return;
        }
        let Some(course) = self.course(&light) else { return };
        let wanted = parts.wanted.par_chunks(CHUNK * words);
        let visible = parts.visible.par_chunks_mut(CHUNK * words);
        let chunks = parts.queries.par_chunks(CHUNK).zip(wanted).zip(visible).with_max_len(TASK);
        chunks.for_each(|((queries, wanted), visible)| {
            self.isa.run(Chunk { course: &course, pattern, words, queries, wanted, visible });
        });
    }

    fn supports_light(&self, _light: &AreaLight) -> Result<(), UnsupportedLight> {
        Ok(())
    }

    fn prepare(&mut self, frame: &Frame) {
        self.grid.clear();
        self.frustum = frustum::depth_range(frame).map(|range| {
            let aspect = frame.gbuffer.width as f32 / frame.gbuffer.height as f32;
            Frustum::new(&frame.scene.camera, aspect, range, self.grid.side(), self.grid.bits())
        });
        if let Some(frustum) = &self.frustum {
            rasterize::rasterize(&self.grid, frustum, &frame.scene.mesh);
            self.grid.build_levels();
        }
    }

    fn bytes(&self) -> usize {
        self.grid.bytes()
    }
}

/// Offset of ray origins from surfaces in addition to the bias, relative to the largest coordinate: the
/// rounding error of voxel coordinates, which matters far from the origin where a voxel is little larger.
const ROUNDING: f32 = 1.0 / 4_194_304.0;

/// Data that all rays to one light share.
struct Course<'a> {
    grid: &'a Grid,
    frustum: &'a Frustum,
    measures: Measures,
    config: VoxelConfig,
    /// Light in homogeneous coordinates.
    light: AreaLight,
    /// Point of the light, world space.
    place: Vec3,
    /// Normal of the light, world space.
    normal: Vec3,
    turned_normal: Vec3,
    /// Distance before the light's plane at which rays end, metres.
    clearance: f32,
}

impl Course<'_> {
    /// Origin of a receiver's rays, offset from its surface by the bias, and the light offset from its plane,
    /// in homogeneous coordinates.
    #[inline(always)]
    fn ends(&self, origin: Vec3, normal: Vec3) -> (Vec3, AreaLight) {
        let rounding = origin.abs().max_element() * ROUNDING;
        let start =
            origin + normal * (self.config.bias * self.frustum.width_along(origin, normal) + rounding);
        // A receiver close to the light's plane must not end up behind the offset light.
        let height = self.normal.dot(origin - self.place);
        let lift = self.clearance.min(height.abs() * 0.5).copysign(height);
        let light = self.light.moved(self.turned_normal * lift);
        (self.frustum.place(start).as_vec3(), light)
    }

    /// Mask of the `active` rays for which `meets` returns true somewhere in a run; see [`march::march`].
    #[inline(always)]
    fn march<S: Simd>(
        &self,
        rays: &Rays,
        run: Run,
        active: u32,
        meets: impl FnMut(usize, usize, usize, usize) -> bool,
    ) -> u32 {
        let VoxelConfig { traversal, thickness, .. } = self.config;
        march::march::<S::Wide>(traversal, thickness, &self.measures, rays, run, active, meets)
    }
}

/// Neighbouring queries of a batch.
struct Chunk<'a> {
    course: &'a Course<'a>,
    pattern: Pattern,
    words: usize,
    queries: &'a [Query],
    wanted: &'a [u64],
    visible: &'a mut [u64],
}

impl Kernel for Chunk<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let Course { grid, measures, config, .. } = self.course;
        for (index, query) in self.queries.iter().enumerate() {
            let (origin, light) = self.course.ends(query.origin, query.normal);
            let thickness = if config.traversal == Traversal::Dda { 0 } else { config.thickness };
            let runs = fan::runs::<S::Wide>(grid, measures, thickness, origin, &light);
            for word in 0..self.words {
                let slot = index * self.words + word;
                let wanted = self.wanted[slot];
                let mut visible = wanted;
                if !runs.as_slice().is_empty() {
                    for group in (0..64).step_by(LANES) {
                        let mut active = (wanted >> group) as u32 & ((1 << LANES) - 1);
                        if active == 0 {
                            continue;
                        }
                        let ends = positions::<S::Wide>(&light, self.pattern, query.key, word * 64 + group);
                        let rays = Rays { origin, ends: &ends };
                        for &run in runs.as_slice() {
                            let stopped = self.course.march::<S>(&rays, run, active, |_, texel, from, to| {
                                grid.meets(texel, from.min(to), from.max(to))
                            });
                            visible &= !(u64::from(stopped) << group);
                            active &= !stopped;
                            if active == 0 {
                                break;
                            }
                        }
                    }
                }
                self.visible[slot] = visible;
            }
        }
    }
}
