//! Whole frames for programs that wait for them: rendered, and read back as the CPU's.

use std::f32::consts::FRAC_1_PI;
use std::sync::mpsc;

use glam::Vec3;
use halflight_core::gbuffer::{GBuffer, NO_PRIMITIVE};
use halflight_core::specular::SurfaceSpecular;
use halflight_cpu::pipeline::Image;

use crate::emission;
use crate::error::GpuError;
use crate::gpu::Gpu;
use crate::inputs::{Inputs, Inside};
use crate::renderer::Renderer;
use crate::stats::GpuStats;

fn xyz([x, y, z, _]: [f32; 4]) -> Vec3 {
    Vec3::new(x, y, z)
}

/// Returns the radiance of pixels where it does not follow from the other layers: albedo/π · irradiance and what is reflected specularly.
fn radiance(irradiance: &[[f32; 4]], albedo: &[[f32; 4]], specular: &[Vec3]) -> Vec<Vec3> {
    let diffuse = irradiance.iter().zip(albedo).map(|(&light, &albedo)| xyz(light) * xyz(albedo) * FRAC_1_PI);
    diffuse.zip(specular).map(|(diffuse, &specular)| diffuse + specular).collect()
}

impl Gpu {
    /// Renders a frame and waits for it and its statistics.
    ///
    /// # Errors
    /// The frame cannot be recorded, or the device is lost.
    pub fn render(&self, renderer: &mut Renderer, inputs: &Inputs) -> Result<GpuStats, GpuError> {
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        renderer.record(&mut encoder, inputs)?;
        let pending = renderer.read_stats(&mut encoder);
        self.queue.submit([encoder.finish()]);
        let failed = |error: &dyn std::fmt::Display| GpuError::Readback(error.to_string());
        let (send, receive) = mpsc::channel();
        pending.read(move |stats| {
            // The other end waits below.
            let _ = send.send(stats);
        });
        self.device.poll(wgpu::PollType::wait_indefinitely()).map_err(|error| failed(&error))?;
        receive.try_recv().map_err(|error| failed(&error))?
    }

    /// Reads the last frame back: the image, with levels but without its statistics and the visible part, and the G-buffer. The image has
    /// radiance and emission where a light is [visible](halflight_core::light::AreaLight::visible).
    ///
    /// # Errors
    /// The device is lost or out of memory.
    pub fn download(&self, renderer: &Renderer) -> Result<(Image, GBuffer), GpuError> {
        let (width, height) = renderer.size();
        let irradiance: Vec<[f32; 4]> = self.read(renderer.image())?;
        let position: Vec<[f32; 4]> = self.read(renderer.position())?;
        let normal: Vec<[u32; 4]> = self.read(renderer.normal())?;
        let albedo: Vec<[f32; 4]> = self.read(renderer.albedo())?;
        let level: Vec<u32> = self.read(renderer.inside(Inside::Owners))?;
        let specular = match renderer.specular() {
            Some(specular) => self.read::<[f32; 4]>(specular)?.into_iter().map(xyz).collect(),
            None => Vec::new(),
        };
        let mut image = Image {
            radiance: radiance(&irradiance, &albedo, &specular),
            specular,
            width,
            height,
            irradiance: irradiance.into_iter().map(xyz).collect(),
            level: level.into_iter().map(|level| level.min(u8::MAX.into()) as u8).collect(),
            ..Image::default()
        };
        let mut gbuffer = GBuffer::default();
        gbuffer.reset(width, height);
        let vector =
            |[x, y, z, _]: [u32; 4]| Vec3::new(f32::from_bits(x), f32::from_bits(y), f32::from_bits(z));
        gbuffer.shading = normal[position.len()..].iter().copied().map(vector).collect();
        if let Some(gloss) = renderer.gloss() {
            let surface =
                |[r, g, b, roughness]: [f32; 4]| SurfaceSpecular { f0: Vec3::new(r, g, b), roughness };
            gbuffer.specular = self.read(gloss)?.into_iter().map(surface).collect();
        }
        for (pixel, (position, normal)) in position.into_iter().zip(normal).enumerate() {
            let primitive = normal[3];
            gbuffer.primitive[pixel] = primitive;
            if primitive != NO_PRIMITIVE {
                gbuffer.position[pixel] = xyz(position);
                gbuffer.depth[pixel] = position[3];
                gbuffer.normal[pixel] = vector(normal);
                gbuffer.albedo[pixel] = xyz(albedo[pixel]);
            }
        }
        if let Some(emission) = renderer.emission() {
            emission::fill(&mut image, &gbuffer, &self.read::<[f32; 4]>(emission)?);
        }
        Ok((image, gbuffer))
    }
}
