//! Percentage-closer soft shadows: Fernando, "Percentage-Closer Soft Shadows", SIGGRAPH Sketches 2005.
//!
//! 1. The shadow map is searched where surfaces may hide the light: as wide as the light seen from the receiver at the depth
//!    of the nearest surface there, which a hierarchy of largest inverse depths tells. Where no sample is a blocker, the
//!    receiver is lit; where all are, it is in the umbra.
//! 2. The blockers' mean inverse depth `b` and the receiver's `r` give the width of the penumbra: in the map, the light's
//!    edges times `b − r`.
//! 3. Percentage-closer filtering over that width and a texel.
//!
//! Samples lie on the light's parallelogram (R2 sequence), moved in each pixel by a hash. What differs from the sketch: a
//! blocker lies above the receiver's tangent plane, the search is no wider than the
//! surfaces there make it (Guennebaud, Barthe, Paulin 2006), and the visible fraction is multiplied with the
//! analytic irradiance, as in all other rows.

use std::sync::{Arc, Mutex, PoisonError};

use glam::{Vec2, Vec3};
use halflight_core::fragment::Fragments;
use halflight_core::frame::Frame;
use halflight_core::gbuffer::GBuffer;
use halflight_core::hash;
use halflight_core::light::AreaLight;
use halflight_core::mask::MaskBatch;
use halflight_core::stages::{RefineOutput, Refiner, UnsupportedLight, Upsampler, Visibility};
use halflight_cpu::bvh::Bvh;
use halflight_cpu::multiversion;
use halflight_cpu::pipeline::PipelineBuilder;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::shadow_map::{LANES, Seen, ShadowMap};

/// Constants of percentage-closer soft shadows.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PcssConfig {
    /// Texels along either side of a shadow map, 16 to 8192.
    pub resolution: u32,
    /// Samples of the search for blockers.
    pub search: u32,
    /// Samples of the filter.
    pub samples: u32,
    /// Depth by which a blocker lies above a receiver, in widths of a texel there: less shows texels on curved surfaces, more
    /// loses shadows at contacts.
    pub bias: f32,
}

impl Default for PcssConfig {
    fn default() -> Self {
        Self { resolution: 1024, search: 32, samples: 64, bias: 0.5 }
    }
}

impl PcssConfig {
    /// Returns the bytes of a map and of the G-buffer that it is traced into.
    pub(super) fn bytes_needed(&self) -> u64 {
        u64::from(self.resolution).pow(2) * 60
    }
}

/// Maps of the lights: towards their normal, and away from it for two-sided ones.
type Maps = Arc<Mutex<Vec<[Option<ShadowMap>; 2]>>>;

/// Puts the stages into a pipeline: maps are traced where backends prepare a frame, and filtered where pixels are
/// interpolated.
pub(super) fn stages(config: PcssConfig, builder: PipelineBuilder, bvh: &Arc<Bvh>) -> PipelineBuilder {
    let maps = Maps::default();
    let (bvh, shared) = (Arc::clone(bvh), Arc::clone(&maps));
    builder
        .refiner(Whole)
        .visibility(ShadowMaps {
            bvh,
            resolution: config.resolution,
            maps: shared,
            scratch: GBuffer::default(),
        })
        .upsampler(Filter { config, maps })
}

/// Refiner that asks for nothing: all cells are empty.
struct Whole;

impl Refiner for Whole {
    fn refine(
        &mut self,
        frame: &Frame,
        _light: u32,
        _visibility: &mut dyn Visibility,
        fragments: &mut Fragments,
    ) -> RefineOutput<'_> {
        const LEVEL: u8 = 6;
        let GBuffer { width, height, .. } = *frame.gbuffer;
        for y in 0..height.div_ceil(1 << LEVEL) {
            for x in 0..width.div_ceil(1 << LEVEL) {
                fragments.push_cell(LEVEL, x, y, &[]);
            }
        }
        RefineOutput::default()
    }

    fn coarsest_level(&self) -> u8 {
        0
    }
}

/// Backend that traces the shadow maps of a frame.
struct ShadowMaps {
    bvh: Arc<Bvh>,
    resolution: u32,
    maps: Maps,
    scratch: GBuffer,
}

impl Visibility for ShadowMaps {
    /// Lets everything be seen: the refiner that goes with it asks for nothing.
    fn masks(&mut self, _frame: &Frame, batch: &mut MaskBatch) {
        let parts = batch.parts();
        parts.visible.copy_from_slice(parts.wanted);
    }

    fn supports_light(&self, light: &AreaLight) -> Result<(), UnsupportedLight> {
        super::flat("pcss", light)
    }

    fn prepare(&mut self, frame: &Frame) {
        let Self { bvh, resolution, maps, scratch } = self;
        let of = |light: &AreaLight| {
            let normal = light.normal();
            let mut map =
                |axis| ShadowMap::trace(frame.scene, bvh, light, axis, frame.gbuffer, *resolution, scratch);
            [map(normal), if light.two_sided { map(-normal) } else { None }]
        };
        let made = frame.scene.lights.iter().map(of).collect();
        *maps.lock().unwrap_or_else(PoisonError::into_inner) = made;
    }

    fn bytes(&self) -> usize {
        self.scratch.bytes() + self.resolution.pow(2) as usize * size_of::<f32>()
    }
}

/// Upsampler that filters the shadow maps at every pixel.
struct Filter {
    config: PcssConfig,
    maps: Maps,
}

impl Upsampler for Filter {
    fn upsample(&mut self, frame: &Frame, fragments: &Fragments, _values: &[f32], out: &mut [f32]) {
        let maps = self.maps.lock().unwrap_or_else(PoisonError::into_inner);
        let number = fragments.light();
        let (light, seen) = (frame.light(number), frame.gbuffer);
        let Some(sides) = maps.get(number as usize) else { return out.fill(1.0) };
        let points = [self.config.search, self.config.samples].map(r2);
        let key = |pixel: usize| hash::pattern_key(pixel as u32, number, frame.index, frame.seed);
        out.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, out)| {
            let (mut receivers, mut turns) = ([Receiver::default(); CHUNK], [Vec2::ZERO; CHUNK]);
            for (lane, pixel) in (chunk * CHUNK..).take(out.len()).enumerate() {
                let side = usize::from(light.side(seen.position[pixel]) <= 0.0);
                // The back of a light, or no surface: there is no light to be hidden.
                let map = sides[side].as_ref().filter(|_| seen.is_receiver(pixel));
                receivers[lane] = Receiver { map, point: seen.position[pixel], normal: seen.normal[pixel] };
                turns[lane] = hash::unit_pair(key(pixel)).into();
            }
            visible_fractions(&receivers, &turns, &points, self.config.bias, out);
        });
    }
}

/// Pixels that a task filters.
const CHUNK: usize = 256;

/// Surface point and the map in which it is looked up, if any.
#[derive(Clone, Copy, Default)]
struct Receiver<'a> {
    map: Option<&'a ShadowMap>,
    point: Vec3,
    normal: Vec3,
}

/// Points in the unit square, by coordinate, in blocks; the last block may have more than are used.
struct Points {
    count: usize,
    blocks: Vec<[[f32; LANES]; 2]>,
}

/// Returns the first points of the R2 sequence (Roberts 2018).
fn r2(count: u32) -> Points {
    const STEPS: [f64; 2] = [0.754_877_666_246_693, 0.569_840_290_998_053];
    let point = |index: usize, step: f64| (0.5 + index as f64 * step).fract() as f32;
    let block =
        |block: usize| STEPS.map(|step| std::array::from_fn(|lane| point(block * LANES + lane, step)));
    let count = count as usize;
    Points { count, blocks: (0..count.div_ceil(LANES)).map(block).collect() }
}

impl Points {
    /// Returns the inverse depths of blockers between a receiver and the points on the light, summed, and their number.
    #[inline(always)]
    fn blockers(&self, map: &ShadowMap, seen: &Seen, nearer: f32, turn: Vec2) -> (f32, usize) {
        let (mut sum, mut count) = (0.0, 0);
        for (number, block) in self.blocks.iter().enumerate() {
            let mut places = *block;
            for (coordinates, turn) in places.iter_mut().zip(turn.to_array()) {
                for coordinate in coordinates {
                    let moved = *coordinate + turn;
                    *coordinate = moved - if moved >= 1.0 { 1.5 } else { 0.5 };
                }
            }
            let found = map.blockers(seen, nearer, &places);
            for value in found.into_iter().take(self.count - number * LANES) {
                sum += value;
                count += usize::from(value > 0.0);
            }
        }
        (sum, count)
    }
}

multiversion! {
    /// Computes the visible fractions of the light; 1 outside of the map, 0 without one.
    fn visible_fractions(receivers: &[Receiver], turns: &[Vec2], points: &[Points; 2], bias: f32, out: &mut [f32]) {
        let [search, filter] = points;
        for ((receiver, &turn), out) in receivers.iter().zip(turns).zip(out) {
            let Some(map) = receiver.map else {
                *out = 0.0;
                continue;
            };
            *out = 1.0;
            let Some(seen) = map.project(receiver.point, receiver.normal, bias) else { continue };
            let reach = map.reach(&seen);
            if reach == 0.0 {
                continue;
            }
            let (sum, count) = search.blockers(map, &seen, reach, turn);
            if count == search.count {
                *out = 0.0;
            } else if count > 0 {
                let nearer = (sum / count as f32 - seen.inverse).max(0.0);
                let (_, blocked) = filter.blockers(map, &seen, nearer, turn);
                *out = 1.0 - blocked as f32 / filter.count as f32;
            }
        }
    }
}
