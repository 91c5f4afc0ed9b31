//! Coarse shadow maps, one from each light sample: what Nichols10 (Fig. 8) sets its voxels against. They are what imperfect shadow maps (Ritschel 2008)
//! would be without holes.
//!
//! 1. From each light sample, rays go through the middles of a map's texels, which cover the half space before the light as a paraboloid (Brabec 2002).
//! 2. Every pixel looks up every light sample: the sample is hidden where the map's surface is nearer than the receiver, which is moved along its normal by a
//!    part of a texel's width there (normal offset).

use std::sync::Arc;

use glam::{Vec2, Vec3};
use halflight_core::frame::Frame;
use halflight_core::light::AreaLight;
use halflight_core::mask::MaskBatch;
use halflight_core::pattern::{Pattern, PatternKind};
use halflight_core::stages::{UnsupportedLight, Visibility};
use halflight_cpu::bvh::Bvh;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Constants of coarse shadow maps.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CoarseMapsConfig {
    /// Texels along either side of a map, 8 to 1024.
    pub resolution: u32,
    /// Light samples, each with a map.
    pub samples: u32,
    /// Distance by which receivers are moved along their normal, in widths of a texel there: less shows texels on surfaces, more loses shadows at contacts.
    pub bias: f32,
}

impl Default for CoarseMapsConfig {
    /// Returns the constants of Fig. 8: 1,024 maps of 64 × 64 texels.
    fn default() -> Self {
        Self { resolution: 64, samples: 1024, bias: 1.0 }
    }
}

impl CoarseMapsConfig {
    /// Returns the bytes of the maps of a two-sided light.
    pub(super) fn bytes_needed(&self) -> u64 {
        u64::from(self.resolution).pow(2) * u64::from(self.samples) * 8
    }
}

/// Map of distances from a point of a light.
struct PointMap {
    eye: Vec3,
    /// Distances to the nearest surface, m, row by row; infinite where there is none.
    distances: Vec<f32>,
}

/// Maps of one side of a light.
struct Side {
    /// Unit axes: columns, rows, and the direction of the side.
    axes: [Vec3; 3],
    /// Maps by light sample.
    maps: Vec<PointMap>,
}

/// Backend that looks up a shadow map for each light sample.
pub(super) struct CoarseMaps {
    bvh: Arc<Bvh>,
    config: CoarseMapsConfig,
    /// Pattern of the samples that the maps belong to.
    pattern: Pattern,
    /// Sides of each light: along its normal, and away from it for a two-sided one.
    lights: Vec<[Option<Side>; 2]>,
}

impl CoarseMaps {
    pub(super) fn new(config: CoarseMapsConfig, bvh: &Arc<Bvh>) -> Self {
        let pattern = Pattern { kind: PatternKind::Grid, columns: 0, rows: 0 };
        Self { bvh: Arc::clone(bvh), config, pattern, lights: Vec::new() }
    }

    /// Traces the maps of one side of a light.
    fn trace(&self, frame: &Frame, number: u32, light: &AreaLight, axis: Vec3) -> Side {
        let (right, down) = axis.any_orthonormal_pair();
        let (mesh, size) = (&frame.scene.mesh, self.config.resolution);
        let (low, high) = mesh.bounds().unwrap_or_default();
        // As far as the corner of the scene that is farthest from any point of the light, and so that a light far away has segments that end.
        let reach = light.corners().map(|corner| (low - corner).abs().max((high - corner).abs()).length());
        let far = reach.into_iter().fold(1e-3, f32::max) * 1.01;
        let direction = |texel: u32| {
            let place = Vec2::new((texel % size) as f32 + 0.5, (texel / size) as f32 + 0.5) / size as f32;
            let flat = place * 2.0 - 1.0;
            let squared = flat.length_squared();
            (right * (2.0 * flat.x) + down * (2.0 * flat.y) + axis * (1.0 - squared)) / (1.0 + squared)
        };
        let directions: Vec<Vec3> = (0..size * size).map(direction).collect();
        let key = frame.shared_key(number);
        let map = |sample: usize| {
            let eye = light.point(frame.pattern.position(sample, key));
            let ends: Vec<Vec3> = directions.iter().map(|&direction| eye + direction * far).collect();
            let mut distances = vec![0.0; ends.len()];
            self.bvh.first_hits(mesh, eye, &ends, &mut distances);
            distances.iter_mut().for_each(|distance| *distance *= far);
            PointMap { eye, distances }
        };
        let maps = (0..frame.pattern.len()).into_par_iter().map(map).collect();
        Side { axes: [right, down, axis], maps }
    }
}

impl Side {
    /// Returns whether a receiver sees a light sample.
    #[inline]
    fn sees(&self, sample: usize, origin: Vec3, normal: Vec3, size: f32, bias: f32) -> bool {
        let PointMap { eye, distances } = &self.maps[sample];
        let [right, down, axis] = self.axes;
        let place = |from: Vec3, distance: f32| {
            Vec2::new(from.dot(right), from.dot(down)) / (distance + from.dot(axis)).max(f32::MIN_POSITIVE)
        };
        let from = origin - eye;
        let distance = from.length();
        // An angle dθ is (1 + r²) / 2 · dθ on the paraboloid's plane, whose texels are 2 / size wide.
        let texel = 4.0 / (size * (1.0 + place(from, distance).length_squared()));
        let from = from + normal * (bias * texel * distance);
        let distance = from.length();
        let texel = ((place(from, distance) * 0.5 + 0.5) * size).clamp(Vec2::ZERO, Vec2::splat(size - 1.0));
        let index = texel.y as usize * size as usize + texel.x as usize;
        distances.get(index).is_none_or(|&nearest| distance <= nearest)
    }
}

impl Visibility for CoarseMaps {
    fn masks(&mut self, frame: &Frame, batch: &mut MaskBatch) {
        let (number, words, pattern) = (batch.light() as usize, batch.words(), batch.pattern());
        let light = *frame.light(batch.light());
        let parts = batch.parts();
        let sides = self.lights.get(number).filter(|_| pattern == self.pattern);
        let (Some(sides), true) = (sides, words > 0) else {
            return parts.visible.copy_from_slice(parts.wanted);
        };
        let (size, bias) = (self.config.resolution as f32, self.config.bias);
        let masks = parts.visible.par_chunks_mut(words).zip(parts.wanted.par_chunks(words));
        masks.zip(parts.queries).with_min_len(16).for_each(|((visible, wanted), query)| {
            let Some(side) = &sides[usize::from(light.side(query.origin) <= 0.0)] else {
                return visible.copy_from_slice(wanted);
            };
            for (word, (visible, &wanted)) in visible.iter_mut().zip(wanted).enumerate() {
                let (mut left, mut seen) = (wanted, 0);
                while left != 0 {
                    let bit = left.trailing_zeros();
                    left &= left - 1;
                    let sample = word * 64 + bit as usize;
                    seen |= u64::from(side.sees(sample, query.origin, query.normal, size, bias)) << bit;
                }
                *visible = seen;
            }
        });
    }

    fn supports_light(&self, light: &AreaLight) -> Result<(), UnsupportedLight> {
        super::flat("coarse-maps", light)
    }

    fn prepare(&mut self, frame: &Frame) {
        let lights = frame.scene.lights.iter().zip(0..).map(|(light, number)| {
            let normal = light.normal();
            let back = light.two_sided.then(|| self.trace(frame, number, light, -normal));
            [Some(self.trace(frame, number, light, normal)), back]
        });
        self.lights = lights.collect();
        self.pattern = frame.pattern;
    }

    fn bytes(&self) -> usize {
        let sides = self.lights.iter().flatten().flatten();
        sides.flat_map(|side| &side.maps).map(|map| map.distances.len() * size_of::<f32>()).sum()
    }
}
