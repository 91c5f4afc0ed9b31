//! The `raster4d` visibility backend (Wang17): receivers and triangles are projected through all points of
//! the light at once, and those whose projections overlap are paired.
//!
//! Per light and frame, all triangles are binned into a framebuffer beyond the scene (`project`, `cells`;
//! STEPs 2 and 4). A receiver reads the one cell that it is projected to through the light's corner (STEP 3,
//! §3.2), keeps the triangles whose rectangle covers all of its own (§3.2), and removes whole rows of its
//! mask for each (STEP 5, §3.3). Any number of receivers in any positions is possible: the whole image or the
//! samples that a refiner wants.

mod answer;
mod cells;
mod cover;
mod project;
#[cfg(test)]
mod tests;

use halflight_core::frame::Frame;
use halflight_core::light::AreaLight;
use halflight_core::mask::MaskBatch;
use halflight_core::pattern::{Pattern, PatternKind};
use halflight_core::scene::Mesh;
use halflight_core::stages::{Unsupported, UnsupportedLight, Visibility};
use halflight_core::stats::VisibilityStats;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::occluder::{Points, Rows, Triangle};
use crate::pool::{Pool, TASK};
use crate::shaft::GROUP;
use crate::simd::Isa;
use answer::{Chunk, Worker, answer};
use cells::Cells;

/// Most cells per side that a triangle covers before it goes to a coarser framebuffer. A smaller value
/// lengthens the lists beyond what they save; a larger one makes more entries.
const SPAN: u16 = 4;

/// Options of 4D rasterization. The switches allow to measure the gain of each of the paper's optimisations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Raster4dConfig {
    /// Cells per side of the framebuffer (Wang17 §4.2, Table 6: 128 is best of 32, 64, 128 and 256).
    pub framebuffer: u32,
    /// True if a receiver reads one cell instead of all that its projection covers (Wang17 §3.2, Algorithm
    /// 2).
    pub one_cell: bool,
    /// True if pairs whose projections do not cover each other are dropped (Wang17 §3.2, Algorithm 3).
    pub rejection: bool,
    /// True if masks are computed by rows instead of sample by sample (Wang17 §3.3).
    pub rows: bool,
    /// True if triangles that cover many cells are stored in coarser framebuffers, one per power of two. Not
    /// in the paper, whose lists grow with the square of the light's projected size.
    pub coarser: bool,
    /// True if neighbouring receivers read their cells together and test the triangles found against the
    /// shaft to the light. Not in the paper. Requires `one_cell` and `rejection`; without either it has no
    /// effect.
    pub shafts: bool,
    /// True if pairs in which the triangle hides a sample are counted, one by one, which is slow. Only
    /// without `shafts`.
    pub count_relevant: bool,
}

impl Default for Raster4dConfig {
    fn default() -> Self {
        Self {
            framebuffer: 128,
            one_cell: true,
            rejection: true,
            rows: true,
            coarser: true,
            shafts: true,
            count_relevant: false,
        }
    }
}

/// Reason for which 4D rasterization cannot be set up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Raster4dError {
    /// Framebuffer size out of range.
    #[error("a framebuffer of {0} cells a side was asked for; {min} to {max} are possible", min = Raster4d::FRAMEBUFFERS.0, max = Raster4d::FRAMEBUFFERS.1)]
    Framebuffer(u32),
    /// Conflict of `count_relevant` and `shafts`: shafts drop pairs before they can be counted.
    #[error("count_relevant needs shafts = false: shafts leave pairs out before they are counted")]
    Relevant,
}

/// Exact visibility by 4D rasterization, for grids and grids with shifted rows.
#[derive(Debug)]
pub struct Raster4d {
    config: Raster4dConfig,
    isa: Isa,
    triangles: Vec<Triangle>,
    /// Largest absolute coordinate of the mesh.
    largest: f32,
    /// For each light its front, then its back if it is two-sided.
    sides: Vec<[Option<Cells>; 2]>,
    stats: VisibilityStats,
    rows: Pool<Worker<Rows>>,
    points: Pool<Worker<Points>>,
}

impl Raster4d {
    /// Smallest and largest framebuffer.
    pub const FRAMEBUFFERS: (u32, u32) = (1, 4096);

    /// Creates the backend; the framebuffer is built by the first frame.
    ///
    /// # Errors
    /// An error if the framebuffer is too small or too large.
    pub fn new(config: Raster4dConfig) -> Result<Self, Raster4dError> {
        let (least, most) = Self::FRAMEBUFFERS;
        if !(least..=most).contains(&config.framebuffer) {
            return Err(Raster4dError::Framebuffer(config.framebuffer));
        }
        if config.count_relevant && config.shafts {
            return Err(Raster4dError::Relevant);
        }
        Ok(Self {
            config,
            isa: Isa::best(),
            triangles: Vec::new(),
            largest: 0.0,
            sides: Vec::new(),
            stats: VisibilityStats::default(),
            rows: Pool::default(),
            points: Pool::default(),
        })
    }

    /// Selects another instruction set; the masks are identical. For comparison.
    #[must_use]
    pub fn with_isa(self, isa: Isa) -> Self {
        Self { isa, ..self }
    }
}

impl Visibility for Raster4d {
    fn supports(&self, pattern: Pattern) -> Result<(), Unsupported> {
        if Rows::fit(pattern) {
            return Ok(());
        }
        let reason = if pattern.kind == PatternKind::Jittered {
            "samples must lie in rows: use grid or shifted-rows"
        } else {
            "at most 64 rows and 64 columns are possible"
        };
        Err(Unsupported::new("raster4d", pattern, reason))
    }

    fn supports_light(&self, light: &AreaLight) -> Result<(), UnsupportedLight> {
        if light.as_sphere().is_none() {
            return Ok(());
        }
        let reason = "triangles are binned by their projection through one plane; use bvh, beam or auto";
        Err(UnsupportedLight::new("raster4d", "sphere lights", reason))
    }

    fn prepare(&mut self, frame: &Frame) {
        let mesh: &Mesh = &frame.scene.mesh;
        let lights = &frame.scene.lights;
        self.stats = VisibilityStats::default();
        (0..mesh.triangle_count() as u32)
            .into_par_iter()
            .with_min_len(1024)
            .map(|index| Triangle::new(mesh, index))
            .collect_into_vec(&mut self.triangles);
        let (low, high) = mesh.bounds().unwrap_or_default();
        self.largest = low.abs().max(high.abs()).max_element();
        let span = self.config.coarser.then_some(SPAN);
        self.sides.resize_with(lights.len(), || [None, None]);
        for (light, sides) in lights.iter().zip(&mut self.sides) {
            for (side, back) in sides.iter_mut().zip([false, true]) {
                if back && !light.two_sided {
                    continue;
                }
                let cells = side.get_or_insert_with(|| Cells::new(self.config.framebuffer));
                cells.fill(mesh, frame.gbuffer, light, back, span);
                self.stats.entries += cells.entry_count() as u64;
            }
        }
    }

    fn masks(&mut self, frame: &Frame, batch: &mut MaskBatch) {
        let (pattern, words) = (batch.pattern(), batch.words());
        let number = batch.light();
        let light = *frame.light(number);
        if words == 0 || !Rows::fit(pattern) {
            return;
        }
        let (config, isa, triangles, largest) = (self.config, self.isa, &self.triangles[..], self.largest);
        let parts = batch.parts();
        // Before the first preparation there are no triangles.
        let Some(sides) = self.sides.get(number as usize) else {
            parts.visible.copy_from_slice(parts.wanted);
            return;
        };
        let wanted = parts.wanted.par_chunks(GROUP * words);
        let visible = parts.visible.par_chunks_mut(GROUP * words);
        let chunks = parts.queries.par_chunks(GROUP).zip(wanted).zip(visible).with_max_len(TASK);
        let chunk = |((queries, wanted), visible)| Chunk {
            config,
            triangles,
            largest,
            light: &light,
            sides,
            words,
            queries,
            wanted,
            visible,
        };
        self.stats += if config.rows && Rows::fit(pattern) {
            chunks.map(|part| answer(&self.rows, isa, pattern, chunk(part))).sum::<VisibilityStats>()
        } else {
            chunks.map(|part| answer(&self.points, isa, pattern, chunk(part))).sum::<VisibilityStats>()
        };
    }

    fn stats(&self) -> VisibilityStats {
        self.stats
    }

    fn bytes(&self) -> usize {
        self.triangles.capacity() * size_of::<Triangle>()
            + self.sides.iter().flatten().flatten().map(Cells::bytes).sum::<usize>()
    }
}
