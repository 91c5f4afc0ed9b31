//! Passes of references: light samples of every pixel.

use std::sync::Arc;

use glam::Vec3;
use halflight_core::fragment::Fragments;
use halflight_core::frame::{Frame, LightSampling, Sharing};
use halflight_core::gbuffer::GBuffer;
use halflight_core::pattern::{PatternError, PatternKind};
use halflight_core::pyramid::Pyramid;
use halflight_core::scene::Scene;
use halflight_core::stages::Refiner;
use halflight_cpu::bvh::Bvh;
use halflight_cpu::irradiance::{Sums, query_sums, texture_sums};
use halflight_cpu::rays::BvhRays;
use halflight_cpu::refine::PerPixel;
use halflight_cpu::requests::Requests;
use rayon::prelude::*;

use super::PASS;
use super::state::{State, planes};

/// Sums of the geometry terms of a pixel's light samples: the pixel, all of them, and the visible ones times the texels of a textured light.
pub(super) type PixelSums = (u32, Sums, Vec3);

/// Stages and buffers that answer for every pixel of a G-buffer.
pub(super) struct LightTracer {
    refiner: PerPixel,
    rays: BvhRays,
    bvh: Arc<Bvh>,
    fragments: Fragments,
    sums: Vec<PixelSums>,
}

impl LightTracer {
    pub(super) fn new(bvh: &Arc<Bvh>) -> Self {
        Self {
            refiner: PerPixel::default(),
            rays: BvhRays::new(Arc::clone(bvh)),
            bvh: Arc::clone(bvh),
            fragments: Fragments::default(),
            sums: Vec::new(),
        }
    }

    /// Traces the samples of a light at every receiver of a frame, and returns their sums in an order that depends on the receivers alone.
    pub(super) fn trace(&mut self, frame: &Frame, number: usize) -> &[PixelSums] {
        let (light, texture) = (frame.light(number as u32), frame.light_texture(number as u32));
        self.fragments.reset(frame.gbuffer.width, frame.gbuffer.height, number as u32);
        let mut rays = Requests::new(&mut self.rays, &self.bvh);
        self.refiner.refine(frame, number as u32, &mut rays, &mut self.fragments);
        let fragments = &self.fragments;
        let sums = fragments.samples().par_iter().map(|sample| {
            let batch = fragments.batch(sample.batch);
            let (first, count) = (sample.first as usize, usize::from(sample.probes));
            let sums = query_sums(light, batch, first, count);
            let visible = match &texture {
                Some(texture) => texture_sums(light, texture, batch, first, count).0,
                None => Vec3::splat(sums.visible),
            };
            (sample.pixel, sums, visible)
        });
        sums.collect_into_vec(&mut self.sums);
        &self.sums
    }
}

/// Stages and buffers that are kept between passes.
pub(super) struct Tracer<'a> {
    scene: &'a Scene,
    seen: &'a GBuffer,
    seed: u32,
    pyramid: Pyramid,
    lights: LightTracer,
}

impl<'a> Tracer<'a> {
    pub(super) fn new(scene: &'a Scene, bvh: &Arc<Bvh>, seen: &'a GBuffer, seed: u32) -> Self {
        Self { scene, seen, seed, pyramid: Pyramid::default(), lights: LightTracer::new(bvh) }
    }

    /// Adds one pass over all lights to its half.
    pub(super) fn pass(&mut self, state: &mut State) -> Result<(), PatternError> {
        let sampling = LightSampling { count: PASS, kind: PatternKind::Jittered, sharing: Sharing::Receiver };
        let frame = Frame {
            scene: self.scene,
            gbuffer: self.seen,
            pyramid: &self.pyramid,
            pattern: sampling.pattern()?,
            sharing: sampling.sharing,
            index: state.passes,
            seed: self.seed,
        };
        let half = (state.passes % 2) as usize;
        for number in 0..self.scene.lights.len() {
            let sums = self.lights.trace(&frame, number);
            for (channel, plane) in planes(self.scene, number).enumerate() {
                let totals = state.totals_mut(half, plane);
                for &(pixel, sums, visible) in sums {
                    let total = &mut totals[pixel as usize];
                    total[0] += f64::from(visible[channel]);
                    total[1] += f64::from(sums.all);
                }
            }
        }
        state.passes += 1;
        Ok(())
    }
}
