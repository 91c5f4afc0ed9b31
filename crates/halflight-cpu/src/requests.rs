//! Requests of refiners to a visibility backend: the one place where masks are asked for.

use std::time::Instant;

use halflight_core::certificate::{Certificate, Region};
use halflight_core::frame::Frame;
use halflight_core::light::AreaLight;
use halflight_core::mask::{MaskBatch, Purpose};
use halflight_core::pattern::Pattern;
use halflight_core::stages::{Unsupported, UnsupportedLight, Visibility};
use halflight_core::stats::RayCounts;

use crate::bvh::Bvh;
use crate::{alpha_masked, horizon, spheres};

/// Backend that culls samples below a horizon before the backend behind it answers, takes out what alpha-masked triangles hide
/// afterwards, completes the answers for sphere lights, counts rays, measures time and refuses patterns that the backend cannot answer.
///
/// Refiners that run outside a [`Pipeline`](crate::pipeline::Pipeline) are given one of these.
pub struct Requests<'a> {
    backend: &'a mut dyn Visibility,
    bvh: &'a Bvh,
    /// BVH over the alpha-masked triangles, if there are any.
    masked: Option<&'a Bvh>,
    /// Rays so far; `total` is left to the caller.
    pub rays: RayCounts,
    /// Time of masks so far, milliseconds.
    pub masks_ms: f64,
    /// Time of certificates so far, milliseconds.
    pub certify_ms: f64,
    /// First refusal; masks of a refused batch are left as they were.
    pub refusal: Option<Unsupported>,
}

impl<'a> Requests<'a> {
    /// Returns requests to a backend that is prepared for the frame. `bvh` is the one over the frame's mesh: backends answer for the
    /// triangles without alpha masks.
    pub fn new(backend: &'a mut dyn Visibility, bvh: &'a Bvh) -> Self {
        let (rays, masked) = (RayCounts::default(), bvh.masked());
        Self { backend, bvh, masked, rays, masks_ms: 0.0, certify_ms: 0.0, refusal: None }
    }
}

impl Visibility for Requests<'_> {
    fn masks(&mut self, frame: &Frame, batch: &mut MaskBatch) {
        let start = Instant::now();
        if let Err(refusal) = self.backend.supports(batch.pattern()) {
            self.refusal.get_or_insert(refusal);
            return;
        }
        let light = frame.light(batch.light());
        let sphere = light.as_sphere().map(|sphere| (sphere, spheres::set_aside(sphere, batch)));
        let culled = horizon::cull(light, batch);
        match batch.purpose() {
            Purpose::Refine => self.rays.refine += culled.traced,
            Purpose::Final => self.rays.last += culled.traced,
        }
        self.rays.skipped += culled.skipped;
        self.backend.masks(frame, batch);
        if let Some(masked) = self.masked {
            alpha_masked::hide(masked, frame, batch);
        }
        if let Some((sphere, surrounded)) = sphere {
            let again = spheres::complete(sphere, self.bvh, frame, batch, &surrounded);
            match batch.purpose() {
                Purpose::Refine => self.rays.refine += again,
                Purpose::Final => self.rays.last += again,
            }
        }
        self.masks_ms += start.elapsed().as_secs_f64() * 1e3;
    }

    fn supports(&self, pattern: Pattern) -> Result<(), Unsupported> {
        self.backend.supports(pattern)
    }

    fn supports_light(&self, light: &AreaLight) -> Result<(), UnsupportedLight> {
        self.backend.supports_light(light)
    }

    fn certify(
        &mut self,
        frame: &Frame,
        light: u32,
        regions: &[Region],
        certificates: &mut Vec<Certificate>,
    ) {
        let start = Instant::now();
        self.backend.certify(frame, light, regions, certificates);
        if let Some(masked) = self.masked {
            alpha_masked::withdraw(masked, frame.light(light), regions, certificates);
        }
        self.certify_ms += start.elapsed().as_secs_f64() * 1e3;
    }
}
