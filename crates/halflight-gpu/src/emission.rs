//! Lights that the camera sees.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;
use halflight_core::gbuffer::GBuffer;
use halflight_core::light::AreaLight;
use halflight_cpu::pipeline::Image;

use crate::bindings::Slot;
use crate::error::GpuError;
use crate::needs::{Needs, RECORD};
use crate::pass::{ByLight, Compiler};
use crate::program::programs;
use crate::recorder::{Groups, Recorder};
use crate::stats::Timed;
use crate::textured::has_texture;

programs! {
    EMISSION: "emission" = see in "emission", "shared/emission";
    TEXTURED: "emission, textured" = see in "emission", "textured/emission";
}

/// Pass that adds a light that the camera sees.
#[derive(Debug)]
pub(crate) struct Emission {
    see: ByLight,
}

/// True if any light can be seen.
pub(crate) fn any_visible(lights: &[AreaLight]) -> bool {
    lights.iter().any(|light| light.visible)
}

impl Emission {
    /// Compiles the pass where any light can be seen.
    ///
    /// # Errors
    /// A shader cannot be read or compiled.
    pub(crate) fn of(compiler: &Compiler, lights: &[AreaLight]) -> Result<Option<Self>, GpuError> {
        let compile = || Ok(Self { see: compiler.by_light((EMISSION, &[]), (TEXTURED, &[]))? });
        any_visible(lights).then(compile).transpose()
    }

    /// True if nothing has to be compiled for these lights.
    pub(crate) fn knows(&self, lights: &[AreaLight]) -> bool {
        self.see.is_textured() || !has_texture(lights)
    }

    /// Declares the radiance and distance of what is seen, where any light can be.
    pub(crate) fn declare(needs: &mut Needs, lights: &[AreaLight]) {
        if any_visible(lights) {
            needs.declare(Slot::Emission, RECORD * needs.pixels());
        }
    }

    /// Records what is seen of all visible lights; the uniforms of each light begin `stride` after those of the one before.
    pub(crate) fn record(&self, recorder: &mut Recorder, stride: u32) {
        let lights = recorder.lights;
        if any_visible(lights) {
            recorder.clear(Slot::Emission);
        }
        for (number, light) in (0..).zip(lights).filter(|(_, light)| light.visible) {
            recorder.textured = light.texture.is_some();
            recorder.run_by_light(&self.see, Timed::Compose, number * stride, Groups::Tiles(0));
        }
    }
}

/// Fills the layers of lights that the camera sees, given [`Slot::Emission`]: their radiance takes the place of the surface's.
pub(crate) fn fill(image: &mut Image, gbuffer: &GBuffer, emission: &[[f32; 4]]) {
    let pixels = image.irradiance.iter().zip(&gbuffer.albedo).zip(emission).enumerate();
    (image.radiance, image.emission) = pixels
        .map(|(pixel, ((&light, &albedo), &[r, g, b, distance]))| match distance {
            0.0 => {
                // Empty where no surface is glossy.
                let specular = image.specular.get(pixel).copied().unwrap_or_default();
                (light * albedo * FRAC_1_PI + specular, Vec3::ZERO)
            }
            _ => (Vec3::new(r, g, b), Vec3::new(r, g, b)),
        })
        .unzip();
}
