//! Light from nearby, by short rays: points would have to lie closer together than they do to stand for it.
//!
//! Rays go out around the shading normal, distributed as its cosine, to the reach of the frame. Where they hit, direct light is computed as it is at points.
//! With the points' part of the light from a distance ([`far`]), each distance counts once.

use std::f32::consts::TAU;

use glam::Vec3;
use halflight_core::gbuffer::{GBuffer, NO_PRIMITIVE};
use halflight_core::hash;
use halflight_core::mask::{MaskBatch, Purpose};
use halflight_core::pattern::Pattern;
use halflight_core::stages::Visibility;

use super::Surroundings;
use super::gather::{Gathered, far};
use super::lit::{Texture, add_light, texture};
use crate::compose::luminance;
use crate::gbuffer::trace_sheaves;

/// Receivers whose rays are traced together.
const BLOCK: usize = 1024;

/// Rows of the grid in which the rays of a receiver are placed.
const ROWS: usize = 4;

/// Light samples of each hit and light.
pub(super) const SAMPLES: usize = 4;

/// Distinguishes the random numbers of short rays from those of light samples.
const SHORT: u32 = 0x5a0e_7000;

/// Short rays, in buffers that are kept.
#[derive(Default)]
pub(crate) struct Near {
    hits: GBuffer,
    batch: MaskBatch,
    light: Vec<Vec3>,
    /// Entries of hits that count, with their parts.
    counted: Vec<(u32, f32)>,
    origins: Vec<Vec3>,
}

impl Near {
    /// Adds the light from within `reach`, metres, to the records of pixels that have some, by `rays` rays each. Returns the number of rays and of
    /// shadow rays from what they hit.
    pub(crate) fn add(
        &mut self,
        surroundings: &mut Surroundings,
        reach: f32,
        rays: usize,
        pixels: &[u32],
        gathered: &mut [Gathered],
    ) -> u64 {
        let due: Vec<usize> = (0..pixels.len()).filter(|&index| gathered[index].near).collect();
        if due.is_empty() {
            return 0;
        }
        let frame = surroundings.frame;
        let pattern = Pattern::with_count(frame.pattern.kind, SAMPLES).unwrap_or(frame.pattern);
        let lights = 0..frame.scene.lights.len() as u32;
        let textures: Vec<Option<Texture>> = lights.map(|number| texture(frame, number, pattern)).collect();
        let mut traced = 0;
        for due in due.chunks(BLOCK) {
            traced += self.block(surroundings, (pattern, &textures), reach, rays, pixels, due, gathered);
        }
        traced
    }

    #[allow(clippy::too_many_arguments)]
    fn block(
        &mut self,
        surroundings: &mut Surroundings,
        (pattern, textures): (Pattern, &[Option<Texture>]),
        reach: f32,
        rays: usize,
        pixels: &[u32],
        due: &[usize],
        gathered: &mut [Gathered],
    ) -> u64 {
        let Self { hits, batch, light, counted, origins } = self;
        let Surroundings { frame, bvh, requests, .. } = surroundings;
        let gbuffer = frame.gbuffer;
        let pixel = |number: usize| pixels[due[number]] as usize;
        origins.clear();
        origins.extend((0..due.len()).map(|number| gbuffer.position[pixel(number)]));
        let key = hash::fold(hash::pattern_key(0, 0, frame.index, frame.seed), SHORT);
        let direction = |number: usize, ray: usize| {
            let pixel = pixel(number);
            let random = hash::unit_pair(hash::sample_bits(hash::fold(key, pixel as u32), ray as u32));
            around(gbuffer.shading_normals()[pixel], ray, rays, random)
        };
        trace_sheaves(bvh, frame.scene, origins, rays, reach, direction, hits);
        counted.clear();
        for (entry, (&triangle, &distance)) in hits.primitive.iter().zip(&hits.depth).enumerate() {
            let part = 1.0 - far(distance * distance, reach * reach);
            let above =
                || direction(entry / rays, entry % rays).dot(gbuffer.normal[pixel(entry / rays)]) > 0.0;
            if triangle != NO_PRIMITIVE && part > 0.0 && above() {
                counted.push((entry as u32, part));
            }
        }
        light.clear();
        light.resize(counted.len(), Vec3::ZERO);
        let before = requests.rays.refine + requests.rays.last;
        for (number, texture) in (0..).zip(textures) {
            batch.reset(number, pattern, Purpose::Final);
            for (query, &(entry, _)) in batch.fill(counted.len()).iter_mut().zip(&*counted) {
                let entry = entry as usize;
                (query.origin, query.normal) = (hits.position[entry], hits.shading_normals()[entry]);
                query.pixel = pixel(entry / rays) as u32;
                let place = hash::fold(query.pixel, (entry % rays) as u32);
                query.key = hash::pattern_key(place, number, frame.index, frame.seed ^ SHORT);
            }
            requests.masks(frame, batch);
            add_light(frame, number, texture.as_ref(), batch, light);
        }
        let share = 1.0 / rays as f32;
        for (&(entry, part), &light) in counted.iter().zip(&*light) {
            let entry = entry as usize;
            let radiosity = hits.albedo[entry] * light * (part * share);
            let record = &mut gathered[due[entry / rays]];
            record.irradiance += radiosity;
            record.nearness += luminance(radiosity) / hits.depth[entry].max(f32::MIN_POSITIVE);
        }
        (due.len() * rays) as u64 + requests.rays.refine + requests.rays.last - before
    }

    /// Memory held, bytes.
    pub(crate) fn bytes(&self) -> usize {
        self.hits.bytes()
            + self.batch.bytes()
            + (self.light.capacity() + self.origins.capacity()) * size_of::<Vec3>()
            + self.counted.capacity() * size_of::<(u32, f32)>()
    }
}

/// Direction of ray `ray` of `rays` around a normal: stratified, distributed as the cosine.
fn around(normal: Vec3, ray: usize, rays: usize, (a, b): (f32, f32)) -> Vec3 {
    let columns = rays.div_ceil(ROWS);
    let turn = TAU * ((ray % columns) as f32 + a) / columns as f32;
    // The rows have equal shares of the rays; the last may be shorter.
    let rows = rays.div_ceil(columns);
    let square = ((ray / columns) as f32 + b) / rows as f32;
    let (sine, height) = (square.sqrt(), (1.0 - square).max(0.0).sqrt());
    let (s, t) = normal.any_orthonormal_pair();
    (s * (sine * turn.cos()) + t * (sine * turn.sin()) + normal * height).normalize_or(normal)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_distributed_as_the_cosine() {
        let normal = Vec3::new(1.0, 2.0, -2.0) / 3.0;
        let (mut mean, mut cosine, mut count) = (Vec3::ZERO, 0.0, 0.0);
        for key in 0..200 {
            for ray in 0..32 {
                let direction = around(normal, ray, 32, hash::unit_pair(hash::sample_bits(key, ray as u32)));
                assert!((direction.length() - 1.0).abs() < 1e-5 && direction.dot(normal) >= 0.0);
                mean += direction;
                cosine += direction.dot(normal);
                count += 1.0;
            }
        }
        // ∫ cos² / ∫ cos = 2/3; nothing to either side.
        assert!((cosine / count - 2.0 / 3.0).abs() < 2e-3, "{}", cosine / count);
        assert!((mean / count - normal * (2.0 / 3.0)).length() < 5e-3, "{mean}");
    }
}
