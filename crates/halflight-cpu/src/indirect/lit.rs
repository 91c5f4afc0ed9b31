//! Direct light at points on the surfaces, on both sides, and what these send on.

use glam::Vec3;
use halflight_core::frame::Frame;
use halflight_core::hash;
use halflight_core::mask::{MaskBatch, Purpose};
use halflight_core::pattern::Pattern;
use halflight_core::stages::Visibility;
use rayon::prelude::*;

use super::Surroundings;
use super::points::Points;
use crate::irradiance::fraction;
use crate::textured::{SeenTexture, StrataRadiance};
use crate::unshadowed::unshadowed;

/// Side of a point that direct light reaches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Emitter {
    /// Start and end of shadow rays on this side, world space.
    pub(crate) origin: Vec3,
    /// Geometric unit normal on this side.
    pub(crate) normal: Vec3,
    /// Area of surface that the point stands for, square metres.
    pub(crate) area: f32,
    /// Radiosity, by channel: irradiance times albedo, W/m².
    pub(crate) radiosity: Vec3,
}

/// Direct light at points, in buffers that are kept.
#[derive(Debug, Default)]
pub(crate) struct Lit {
    batch: MaskBatch,
    irradiance: Vec<Vec3>,
    /// Sides that light reaches, group by group, and in each group side by side.
    pub(crate) emitters: Vec<Emitter>,
    /// Emitters of one side of a group are `sides[i]..sides[i + 1]`.
    pub(crate) sides: Vec<u32>,
}

impl Lit {
    /// Computes the direct light on both sides of all points through the frame's visibility backend, with `samples` light samples each, and keeps the
    /// sides that it reaches. Returns the number of shadow rays.
    pub(crate) fn light(&mut self, surroundings: &mut Surroundings, points: &Points, samples: u32) -> u64 {
        let Self { batch, irradiance, emitters, sides } = self;
        let Surroundings { frame, requests, .. } = surroundings;
        let before = requests.rays.refine + requests.rays.last;
        irradiance.clear();
        irradiance.resize(2 * points.points.len(), Vec3::ZERO);
        let pattern = Pattern::with_count(frame.pattern.kind, samples as usize).unwrap_or(frame.pattern);
        for number in 0..frame.scene.lights.len() as u32 {
            batch.reset(number, pattern, Purpose::Final);
            let queries = batch.fill(irradiance.len());
            queries.par_iter_mut().enumerate().with_min_len(1024).for_each(|(index, query)| {
                let point = &points.points[index / 2];
                query.origin = point.origins[index % 2];
                query.normal = if index % 2 == 0 { point.shading } else { -point.shading };
                query.key = hash::pattern_key(index as u32 / 2, number, frame.index, frame.seed);
            });
            requests.masks(frame, batch);
            let texture = texture(frame, number, pattern);
            add_light(frame, number, texture.as_ref(), batch, irradiance);
        }
        emitters.clear();
        sides.clear();
        for group in points.groups.windows(2) {
            for side in [false, true] {
                let first = emitters.len();
                for index in group[0] as usize..group[1] as usize {
                    let point = &points.points[index];
                    let behind = usize::from(point.turned != side);
                    let radiosity = irradiance[2 * index + behind] * point.albedo;
                    if radiosity.max_element() > 0.0 {
                        let normal = if behind == 0 { point.normal } else { -point.normal };
                        emitters.push(Emitter {
                            origin: point.origins[behind],
                            normal,
                            area: point.area,
                            radiosity,
                        });
                    }
                }
                if emitters.len() > first {
                    sides.push(first as u32);
                }
            }
        }
        sides.push(emitters.len() as u32);
        requests.rays.refine + requests.rays.last - before
    }

    /// Memory held, bytes.
    pub(crate) fn bytes(&self) -> usize {
        self.batch.bytes()
            + self.irradiance.capacity() * size_of::<Vec3>()
            + self.emitters.capacity() * size_of::<Emitter>()
            + self.sides.capacity() * 4
    }
}

/// Texture of a light, as the strata of a pattern and as receivers see it.
pub(super) type Texture = (StrataRadiance, SeenTexture);

/// Texture of a light for a pattern; none for a uniform one.
pub(super) fn texture(frame: &Frame, number: u32, pattern: Pattern) -> Option<Texture> {
    let (light, texture) = (frame.light(number), frame.light_texture(number)?);
    Some((StrataRadiance::new(&texture, light.radiance, pattern), SeenTexture::new(light, &texture)))
}

/// Adds the irradiance of one light at the queries of a batch that has been answered: its unshadowed irradiance times the visible fraction, by channel.
/// `texture` is that of the light for the batch's pattern.
pub(super) fn add_light(
    frame: &Frame,
    number: u32,
    texture: Option<&Texture>,
    batch: &MaskBatch,
    irradiance: &mut [Vec3],
) {
    let light = frame.light(number);
    irradiance.par_iter_mut().enumerate().with_min_len(64).for_each(|(index, out)| {
        let query = &batch.queries()[index];
        let factors = match texture {
            None => Vec3::splat(fraction(light, batch, index).unwrap_or(0.0)),
            Some((strata, seen)) => {
                let sums = strata.fractions(light, batch, index);
                let visible = sums.and_then(|sums| sums.fractions()).map_or(Vec3::ZERO, Vec3::from_array);
                visible * seen.mean_seen(query.origin, query.normal)
            }
        };
        if factors != Vec3::ZERO {
            *out += light.radiance * factors * unshadowed(light, query.origin, query.normal);
        }
    });
}
