//! Order of the stages on the GPU: the one place that states it.

use halflight_core::light::AreaLight;
use halflight_core::pattern::Pattern;
use halflight_core::scene::Scene;
use halflight_core::smooth::is_smooth;
use halflight_cpu::config::PipelineConfig;
use halflight_cpu::pipeline::{MAX_SIZE, PipelineError};

use crate::compose::Compose;
use crate::emission::Emission;
use crate::error::GpuError;
use crate::gbuffer::{Gbuffer, Surfaces};
use crate::masked::Parted;
use crate::needs::Needs;
use crate::pass::Compiler;
use crate::recorder::Recorder;
use crate::refine::{Refiner, Tracer, refiner};
use crate::scene::Corners;
use crate::specular::Reflect;
use crate::stats;
use crate::textured::{TexturedCompose, has_texture};
use crate::upsample::Upsample;
use crate::visibility::backend;

/// All stages of a configuration.
#[derive(Debug)]
pub(crate) struct Stages {
    pub(crate) gbuffer: Gbuffer,
    pub(crate) refiner: Box<dyn Refiner>,
    pub(crate) tracer: Tracer,
    upsample: Upsample,
    compose: Compose,
    /// Passes of glossy surfaces, where there are any.
    reflect: Option<Reflect>,
    /// Passes of textured lights, where there are any.
    textured: Option<TexturedCompose>,
    /// Lights that the camera sees; compiled where the first one comes.
    emission: Option<Emission>,
}

impl Stages {
    /// Compiles the stages for a scene.
    ///
    /// # Errors
    /// A stage does not exist on the GPU, or a shader cannot be read or compiled.
    pub(crate) fn new(
        compiler: &Compiler,
        scene: &Scene,
        parted: &Parted,
        config: &PipelineConfig,
        pattern: Pattern,
    ) -> Result<Self, GpuError> {
        let masked = !parted.masked.is_empty();
        let glossy = scene.mesh.is_glossy();
        let refiner = refiner(compiler, config)?;
        let upsample = Upsample::new(compiler, config)?;
        let visibility = backend(compiler, parted, config)?;
        let reflect = glossy.then(|| Reflect::new(compiler, config, pattern, masked, refiner.smooths()));
        let textured =
            compiler.textured.then(|| TexturedCompose::new(compiler, config.shading, refiner.smooths()));
        Ok(Self {
            reflect: reflect.transpose()?,
            textured: textured.transpose()?,
            gbuffer: Gbuffer::new(compiler, is_smooth(&scene.mesh), masked)?,
            refiner,
            tracer: Tracer::new(compiler, visibility, config.shading, masked)?,
            upsample,
            compose: Compose::new(compiler, config.shading)?,
            emission: Emission::of(compiler, &scene.lights)?,
        })
    }

    /// Returns whether surfaces reflect specularly.
    pub(crate) fn is_glossy(&self) -> bool {
        self.reflect.is_some()
    }

    /// Returns whether textured lights can be rendered.
    pub(crate) fn is_textured(&self) -> bool {
        self.textured.is_some()
    }

    /// Compiles what visible lights that come later need and those before have not.
    ///
    /// # Errors
    /// A shader cannot be read or compiled.
    pub(crate) fn prepare_lights(
        &mut self,
        device: &wgpu::Device,
        lights: &[AreaLight],
    ) -> Result<(), GpuError> {
        if self.emission.as_ref().is_none_or(|emission| !emission.knows(lights)) {
            self.emission =
                Emission::of(&Compiler { device, textured: has_texture(lights), replaced: &[] }, lights)?;
        }
        Ok(())
    }

    /// Returns the needs of all stages for an image of a size.
    ///
    /// # Errors
    /// The image has no pixels or too many.
    pub(crate) fn needs(
        &self,
        width: u32,
        height: u32,
        pattern: Pattern,
        lights: &[AreaLight],
    ) -> Result<Needs, GpuError> {
        if !(1..=MAX_SIZE).contains(&width) || !(1..=MAX_SIZE).contains(&height) {
            return Err(PipelineError::Size { width, height }.into());
        }
        let mut needs = Needs::new(width, height, lights.len() as u32 * self.refiner.uniforms());
        stats::declare(&mut needs);
        Recorder::declare(&mut needs);
        self.gbuffer.declare(&mut needs);
        self.refiner.declare(&mut needs, pattern);
        self.tracer.visibility.declare(&mut needs, lights);
        self.upsample.declare(&mut needs);
        Compose::declare(&mut needs);
        Emission::declare(&mut needs, lights);
        if self.reflect.is_some() {
            Reflect::declare(&mut needs);
        }
        if self.textured.is_some() {
            TexturedCompose::declare(&mut needs, self.refiner.smooths());
        }
        Ok(needs)
    }

    /// Records all stages of a frame, in their order; `corners` are to be rasterized.
    pub(crate) fn record(&self, recorder: &mut Recorder, surfaces: &Surfaces, corners: Corners) {
        self.gbuffer.record(recorder, surfaces, corners);
        if let Some(reflect) = &self.reflect {
            match surfaces {
                Surfaces::Scene => reflect.resolve(recorder),
                Surfaces::Kept => {}
                Surfaces::Points { .. } | Surfaces::Depths { .. } => Reflect::forget(recorder),
            }
        }
        self.refiner.prepare(recorder);
        let uniforms = self.refiner.uniforms();
        self.tracer.visibility.prepare(recorder, uniforms);
        for light in 0..recorder.lights.len() as u32 {
            let first = light * uniforms;
            let textured =
                self.textured.as_ref().filter(|_| recorder.lights[light as usize].texture.is_some());
            recorder.textured = textured.is_some();
            self.tracer.visibility.start(recorder, first);
            if textured.is_some() {
                TexturedCompose::clear(recorder);
            }
            self.refiner.record(recorder, &self.tracer, first);
            let coarsest = self.refiner.coarsest();
            if let Some(reflect) = &self.reflect {
                reflect.record(recorder, first);
            }
            match textured {
                Some(textured) => textured.record(recorder, &self.upsample, first, coarsest),
                None => {
                    self.upsample.record(recorder, first, coarsest);
                    self.compose.record(recorder, first);
                }
            }
        }
        if let Some(emission) = &self.emission {
            emission.record(recorder, uniforms);
        }
        self.refiner.finish(recorder);
    }
}
