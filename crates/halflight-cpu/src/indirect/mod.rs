//! Indirect light: what arrives after one diffuse reflection or more, apart from direct light and added before albedo.
//!
//! Both methods light points on the surfaces (`points`, `lit`; Koa16 §3.2). `Lpv` spreads what they reflect through a grid; `Gather` takes them as the
//! sources of one reflection and tests what hides them.

mod gather;
mod lit;
mod lpv;
mod near;
mod points;
mod records;

use std::sync::Arc;
use std::time::Instant;

use glam::Vec3;
use halflight_core::frame::Frame;
use halflight_core::hash;
use halflight_core::pattern::Pattern;
use halflight_core::scene::Mesh;
use halflight_core::stats::IndirectCounts;
use serde::{Deserialize, Serialize};

use crate::bvh::Bvh;
use crate::requests::Requests;
use crate::segments::Occluders;
use gather::{Effort, Patches, Sources};
use lit::Lit;
pub use lpv::{Lpv, LpvConfig, LpvNormalization};
use points::Points;
use records::{Levels, Records, Task};

/// Distinguishes the random numbers of receivers from those of light samples.
const RECEIVERS: u32 = 0x1d1e_c700;

/// Distance to which short rays go, in radii of the points' disks: from half of it on, points begin to take their place.
const REACH: f32 = 3.0;

/// Scene around the receivers of a frame.
pub struct Surroundings<'a, 'b> {
    /// Frame, with the surfaces that the pixels see.
    pub frame: &'a Frame<'a>,
    /// BVH over all triangles of the scene.
    pub bvh: &'a Bvh,
    /// The mesh before its vertices moved, with the same triangles.
    pub rest: &'a Arc<Mesh>,
    /// Visibility backend for direct light, prepared for the frame.
    pub requests: &'a mut Requests<'b>,
}

/// Computes indirect light.
pub trait Indirect: Send {
    /// Writes the indirect irradiance of every pixel, W/m² by channel, to `out`, row by row from the top left: light that has been reflected
    /// diffusely at least once. Pixels that see nothing get 0.
    fn light(&mut self, surroundings: &mut Surroundings, out: &mut [Vec3]) -> IndirectCounts;

    /// Returns the patterns that the stage will ask the visibility backend for when a full mask has pattern `full`.
    fn patterns(&self, _full: Pattern) -> Vec<Pattern> {
        Vec::new()
    }

    /// Returns the bytes held in buffers.
    fn bytes(&self) -> usize {
        0
    }
}

/// Options of [`Gather`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct GatherConfig {
    /// Points on the surfaces, about, 1 … 1,048,576: 16,384, in groups of about 8.
    pub points: u32,
    /// Light samples of each point and light, 1 … 4096: 16.
    pub light_samples: u32,
    /// Standard deviation of the light at a receiver, as a part of it, that rays come down to: 0.2. The first 64 rays mostly do.
    pub error: f32,
    /// Most shadow rays of a receiver: 512; the first 64 tell how many it takes.
    pub most_rays: u32,
    /// Short rays of a receiver with light from nearby, 0 … 64: 32. They find what is too near to be told by points; with 0 it is lost in part.
    pub near_rays: u32,
    /// Level of the cells that are begun with, 0 … 7: 4, that is 16 × 16 pixels.
    pub coarsest_level: u8,
    /// Level down to which surfaces that end or bend split cells: 2.
    pub finest_level: u8,
    /// Difference between the corners of a cell, as a part of their mean, above which it is split: 0.5.
    pub spread: f32,
}

impl Default for GatherConfig {
    fn default() -> Self {
        Self {
            points: 16_384,
            light_samples: 16,
            error: 0.2,
            most_rays: 512,
            near_rays: 32,
            coarsest_level: 4,
            finest_level: 2,
            spread: 0.5,
        }
    }
}

/// Most points on the surfaces.
pub const MOST_POINTS: u32 = 1 << 20;

/// Indirect light of one reflection, gathered from lit points on the surfaces with exact visibility.
#[derive(Default)]
pub struct Gather {
    config: GatherConfig,
    points: Points,
    lit: Lit,
    patches: Patches,
    records: Records,
}

impl Gather {
    /// Creates the stage. Numbers out of range are taken as the nearest that are in it.
    pub fn new(config: GatherConfig) -> Self {
        let config = GatherConfig {
            points: config.points.clamp(1, MOST_POINTS),
            light_samples: config.light_samples.clamp(1, 4096),
            error: config.error.max(1e-4),
            most_rays: config.most_rays.clamp(64, MOST_POINTS),
            near_rays: config.near_rays.min(64),
            coarsest_level: config.coarsest_level.min(7),
            finest_level: config.finest_level.min(config.coarsest_level.min(7)),
            spread: config.spread.max(0.0),
        };
        Self { config, ..Self::default() }
    }
}

impl Indirect for Gather {
    fn light(&mut self, surroundings: &mut Surroundings, out: &mut [Vec3]) -> IndirectCounts {
        let Self { config, points, lit, patches, records } = self;
        let mut counts = light_points(surroundings, points, lit, config.points, config.light_samples);
        out.fill(Vec3::ZERO);
        if lit.emitters.is_empty() {
            return counts;
        }
        let clock = Instant::now();
        patches.fill(&lit.emitters, &lit.sides);
        let frame = surroundings.frame;
        let occluders = Occluders { bvh: surroundings.bvh, mesh: &frame.scene.mesh };
        let reach = if config.near_rays > 0 { (REACH * points.radius).powi(2) } else { 0.0 };
        let task = Task {
            frame,
            sources: Sources { emitters: &lit.emitters, sides: &lit.sides, patches, occluders, reach },
            near_rays: config.near_rays as usize,
            effort: Effort { error: config.error, most: config.most_rays },
            levels: Levels {
                coarsest: config.coarsest_level,
                finest: config.finest_level,
                spread: config.spread,
            },
            key: hash::fold(hash::pattern_key(0, 0, frame.index, frame.seed), RECEIVERS),
        };
        records.gather(&task, surroundings);
        counts.transport_ms = milliseconds(clock);
        let clock = Instant::now();
        records.interpolate(&task, surroundings, out);
        counts.lookup_ms = milliseconds(clock);
        (counts.records, counts.gather_rays) = records.counts();
        counts
    }

    fn patterns(&self, full: Pattern) -> Vec<Pattern> {
        let counts = [self.config.light_samples as usize, near::SAMPLES];
        counts.into_iter().filter_map(|count| Pattern::with_count(full.kind, count).ok()).collect()
    }

    fn bytes(&self) -> usize {
        self.points.bytes() + self.lit.bytes() + self.patches.bytes() + self.records.bytes()
    }
}

/// Places points on the surfaces where that is due, and lights them.
fn light_points(
    surroundings: &mut Surroundings,
    points: &mut Points,
    lit: &mut Lit,
    count: u32,
    samples: u32,
) -> IndirectCounts {
    let mut counts = IndirectCounts::default();
    let clock = Instant::now();
    if points.follow(&surroundings.frame.scene.mesh, surroundings.rest, count as usize) {
        counts.place_ms = milliseconds(clock);
    }
    let clock = Instant::now();
    counts.light_rays = lit.light(surroundings, points, samples);
    counts.light_ms = milliseconds(clock);
    (counts.points, counts.lit) = (points.points.len() as u64, lit.emitters.len() as u64);
    counts
}

fn milliseconds(clock: Instant) -> f64 {
    clock.elapsed().as_secs_f64() * 1e3
}
