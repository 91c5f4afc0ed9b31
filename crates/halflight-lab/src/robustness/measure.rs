//! Pictures of methods, and their errors against references.

use halflight_cpu::prepared::PreparedScene;
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};

use anyhow::{Context as _, Result};
use glam::Vec3;
use halflight_core::gbuffer::GBuffer;
use halflight_core::scene::Scene;
use halflight_cpu::config::PipelineConfig;
use halflight_cpu::pipeline::PipelineError;
use halflight_cpu::unshadowed::unshadowed;

use super::cases::Case;
use super::judge::{self, Fault, Figure};
use super::methods::Method;
use crate::reference::{ReferenceConfig, reference, seen};

/// Scene and its BVH.
struct Stage(PreparedScene);

impl Stage {
    fn new(scene: &Scene, case: &str) -> Result<Self> {
        Ok(Self(PreparedScene::new(scene.clone()).with_context(|| format!("scene {case}"))?))
    }

    fn seen(&self, size: [u32; 2]) -> GBuffer {
        seen(&self.0, size)
    }

    /// Returns the converged picture.
    fn reference(&self, [width, height]: [u32; 2], samples: u32) -> Result<Vec<Vec3>> {
        let config = ReferenceConfig { width, height, samples, ..ReferenceConfig::default() };
        Ok(reference(&self.0, &config, None, &mut |_, _| {})?.irradiance)
    }

    fn without_shadow(&self, gbuffer: &GBuffer) -> Vec<Vec3> {
        let pixel = |pixel: usize| {
            let Some(receiver) = gbuffer.receiver(pixel) else { return Vec3::ZERO };
            let lights = self.0.scene().lights.iter();
            lights.map(|light| light.radiance * unshadowed(light, receiver.origin, receiver.normal)).sum()
        };
        (0..gbuffer.pixels()).map(pixel).collect()
    }
}

/// Case ready to be rendered, with its references.
pub(super) struct Ready {
    size: [u32; 2],
    stages: Vec<Stage>,
    pub(super) references: Vec<Vec<Vec3>>,
    pub(super) unshadowed: Vec<Vec<Vec3>>,
    /// Pixels that see geometry in all pictures, and in the scene that the reference is of.
    pub(super) mask: Vec<bool>,
}

impl Ready {
    /// Renders the references.
    pub(super) fn new(case: &Case, reference_samples: u32) -> Result<Self> {
        let stage = |scene: &Scene| Stage::new(scene, case.name);
        let stages = case.scenes.iter().map(stage).collect::<Result<Vec<_>>>()?;
        let like = case.like.iter().map(stage).collect::<Result<Vec<_>>>()?;
        let mut mask = vec![true; case.size[0] as usize * case.size[1] as usize];
        for stage in stages.iter().chain(&like) {
            let gbuffer = stage.seen(case.size);
            mask.iter_mut().enumerate().for_each(|(pixel, taken)| *taken &= gbuffer.is_receiver(pixel));
        }
        let truth = if like.is_empty() { &stages } else { &like };
        let references = truth
            .iter()
            .map(|stage| stage.reference(case.size, reference_samples))
            .collect::<Result<_, _>>()?;
        let unshadowed = truth.iter().map(|stage| stage.without_shadow(&stage.seen(case.size))).collect();
        Ok(Self { size: case.size, stages, references, unshadowed, mask })
    }

    /// Renders a method with its own light samples; the pictures may be unsound.
    pub(super) fn render(&self, method: &Method) -> Result<Vec<Vec<Vec3>>, Fault> {
        self.pictures(&method.config(self.size, method.sampling()))
    }

    fn pictures(&self, config: &PipelineConfig) -> Result<Vec<Vec<Vec3>>, Fault> {
        let all = || self.stages.iter().map(|stage| render(stage, config)).collect();
        catch_unwind(AssertUnwindSafe(all)).unwrap_or_else(|cause| Err(Fault::Panic(message(cause.as_ref()))))
    }

    /// Returns how far sound pictures are from the references.
    pub(super) fn figure(&self, pictures: &[Vec<Vec3>]) -> Result<Figure, Fault> {
        pictures.iter().try_for_each(|picture| judge::sound(picture, self.size[0]))?;
        Ok(judge::figure(pictures, &self.references, &self.unshadowed, &self.mask))
    }

    /// Returns NMSE₂ of every pixel by exact rays, with the shading and the light samples of a method; 0 where there is none.
    pub(super) fn error_of_every_pixel(&self, like: &Method) -> f64 {
        let config = Method::every_pixel(like.shading).config(self.size, like.sampling());
        let found = self.pictures(&config).and_then(|pictures| self.figure(&pictures));
        found.map_or(0.0, |figure| figure.nmse2)
    }

    /// Returns NMSE₂ of the pictures without shadows; infinity for several pictures, which are compared by their changes.
    pub(super) fn error_without_shadow(&self) -> f64 {
        if self.references.len() > 1 {
            return f64::INFINITY;
        }
        judge::figure(&self.unshadowed, &self.references, &self.unshadowed, &self.mask).nmse2
    }
}

fn render(stage: &Stage, config: &PipelineConfig) -> Result<Vec<Vec3>, Fault> {
    let refused = |fault: PipelineError| Fault::Refused(fault.to_string());
    let mut pipeline = config.builder(&stage.0).build().map_err(refused)?;
    Ok(pipeline.render().map_err(refused)?.irradiance.clone())
}

/// Returns the message of a panic.
fn message(cause: &(dyn Any + Send)) -> String {
    let text = cause.downcast_ref::<&str>().map(ToString::to_string);
    text.or_else(|| cause.downcast_ref::<String>().cloned()).unwrap_or_else(|| "no message".to_string())
}

#[cfg(test)]
mod tests {
    use halflight_cpu::irradiance::Shading;

    use super::super::cases;
    use super::*;

    fn ready(name: &str) -> Ready {
        let case = cases::all().into_iter().find(|case| case.name == name).unwrap();
        Ready::new(&case, 512).unwrap()
    }

    #[test]
    fn every_pixel_is_near_its_reference_and_no_shadow_is_not() {
        let easy = ready("easy");
        let pictures = easy.render(&Method::every_pixel(Shading::Ratio)).unwrap();
        // Noise of 64 stratified samples, a few 1e-2 of the light where a penumbra is and nothing elsewhere; a missing
        // shadow is a large part of the picture.
        let found = easy.figure(&pictures).unwrap().nmse2;
        assert!(found > 0.0 && found < 1e-3, "{found}");
        assert!(easy.error_without_shadow() > 1e-1);
    }

    #[test]
    fn a_dark_case_has_a_black_reference() {
        let dark = ready("behind");
        assert!(dark.references[0].iter().all(|value| *value == Vec3::ZERO));
        let pictures = dark.render(&Method::every_pixel(Shading::Sampled)).unwrap();
        assert_eq!(dark.figure(&pictures).unwrap(), Figure { nmse2: 0.0, worst: 0.0 });
    }

    #[test]
    fn what_a_panic_said_is_kept() {
        let cause = catch_unwind(|| std::panic::panic_any("out of range")).unwrap_err();
        assert_eq!(message(cause.as_ref()), "out of range");
    }
}
