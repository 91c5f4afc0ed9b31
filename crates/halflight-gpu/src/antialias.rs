//! Antialiased frames for programs that wait for them: one frame a sub-sample, by shifted cameras.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;
use halflight_core::gbuffer::GBuffer;
use halflight_core::subpixel;
use halflight_cpu::pipeline::{Image, PipelineError};

use crate::error::GpuError;
use crate::gbuffer::Surfaces;
use crate::gpu::Gpu;
use crate::inputs::Inputs;
use crate::renderer::Renderer;
use crate::stats::GpuStats;

impl Gpu {
    /// Renders a frame with `sub_samples` in every pixel (1, 4, 8 or 16), waits for it and reads it back.
    ///
    /// Each sub-sample is a whole frame of a camera that is shifted by a part of a pixel, with light samples of its own, so that the image costs as
    /// many frames and is exact at every edge and shadow. Irradiance, [`Image::radiance`] and [`Image::emission`] are means over them; levels and the G-buffer are those
    /// of one more frame, of the pixels' centres, which is the last one rendered and the one of the statistics. Their
    /// [`total_ms`](halflight_core::stats::FrameStats::total_ms) is that of all frames. With 1 sub-sample it is that frame alone, and has no
    /// radiance but where a light is visible.
    ///
    /// # Errors
    /// Pixels cannot have so many sub-samples, the G-buffer is the caller's, a frame cannot be recorded, or the device is lost.
    pub fn render_antialiased(
        &self,
        renderer: &mut Renderer,
        inputs: &Inputs,
        sub_samples: u32,
    ) -> Result<(Image, GBuffer, GpuStats), GpuError> {
        let offsets = match subpixel::offsets(sub_samples).map_err(PipelineError::from)? {
            [_] => &[],
            offsets => offsets,
        };
        if !offsets.is_empty() && !matches!(inputs.surfaces, Surfaces::Scene) {
            return Err(PipelineError::GivenSubSamples.into());
        }
        let (width, height) = renderer.size();
        let pixels = if offsets.is_empty() { 0 } else { width as usize * height as usize };
        let (mut irradiance, mut radiance) = (vec![Vec3::ZERO; pixels], vec![Vec3::ZERO; pixels]);
        // Empty where no light is visible.
        let mut emission = vec![Vec3::ZERO; renderer.emission().map_or(0, |_| pixels)];
        let camera = inputs.camera.unwrap_or(renderer.camera());
        let (mut total_ms, mut lost) = (0.0, 0);
        let share = 1.0 / sub_samples as f32;
        for (number, &offset) in (0..).zip(offsets) {
            let shifted = Inputs {
                camera: Some(subpixel::shifted(&camera, offset, width, height)),
                frame: inputs.frame.wrapping_mul(sub_samples).wrapping_add(number),
                surfaces: inputs.surfaces,
            };
            let stats = self.render(renderer, &shifted)?;
            total_ms += stats.frame.total_ms;
            lost += stats.lost;
            let light: Vec<[f32; 4]> = self.read(renderer.image())?;
            let albedo: Vec<[f32; 4]> = self.read(renderer.albedo())?;
            let glossy = renderer.specular().map(|buffer| self.read::<[f32; 4]>(buffer)).transpose()?;
            let lamps = renderer.emission().map(|buffer| self.read::<[f32; 4]>(buffer)).transpose()?;
            for (pixel, (light, albedo)) in light.into_iter().zip(albedo).enumerate().take(pixels) {
                let [light, albedo] = [light, albedo].map(|[r, g, b, _]| Vec3::new(r, g, b));
                irradiance[pixel] += light * share;
                match lamps.as_ref().map_or([0.0; 4], |lamps| lamps[pixel]) {
                    [_, _, _, 0.0] => {
                        let [r, g, b, _] = glossy.as_ref().map_or([0.0; 4], |glossy| glossy[pixel]);
                        radiance[pixel] += (light * albedo * FRAC_1_PI + Vec3::new(r, g, b)) * share;
                    }
                    [r, g, b, _] => {
                        let lamp = Vec3::new(r, g, b) * share;
                        radiance[pixel] += lamp;
                        emission[pixel] += lamp;
                    }
                }
            }
        }
        let mut stats = self.render(renderer, inputs)?;
        let (mut image, gbuffer) = self.download(renderer)?;
        if !offsets.is_empty() {
            (image.irradiance, image.radiance) = (irradiance, radiance);
            image.emission = emission;
            stats.frame.stages_ms.antialias = total_ms;
            stats.frame.antialias.sub_samples = offsets.len() as u64 * pixels as u64;
        }
        stats.frame.total_ms += total_ms;
        stats.lost += lost;
        Ok((image, gbuffer, stats))
    }
}
