//! What rows of a setting are measured against.

use std::path::Path;
use std::sync::Arc;

use glam::Vec3;
use halflight_core::gbuffer::GBuffer;
use halflight_core::scene::Scene;
use halflight_cpu::gbuffer;
use halflight_image::picture;
use halflight_metrics::{Comparison, Image, compare, write_png};

use super::loaded::Loaded;
use super::progress::Progress;
use crate::error::AblateError;
use crate::experiment::Experiment;
use crate::experiment::plan::{Row, Setting};
use crate::reference::unlit::unlit;
use crate::reference::{Reference, ReferenceConfig, reference};

/// What rows of a setting are measured against.
pub(super) struct Truth {
    pub(super) scene: Arc<Scene>,
    pub(super) reference: Reference,
    /// An image as papers take for a reference.
    pub(super) paper: Option<Vec<Vec3>>,
    pub(super) gbuffer: GBuffer,
    /// Pixels that see geometry.
    receivers: Vec<bool>,
}

impl Truth {
    pub(super) fn new(
        experiment: &Experiment,
        references: &Path,
        setting: &Setting,
        loaded: &Loaded,
        progress: &Progress,
    ) -> Result<Self, AblateError> {
        let scene = loaded.lit(setting.light_scale);
        let config = experiment.reference_of(setting);
        let ReferenceConfig { width, height, seed, .. } = config;
        let mut said = |done: u32, all: u32| {
            progress.now(format!("{}: reference, {done} of {all} samples a pixel", setting.label));
        };
        let reference = reference(&scene, &loaded.bvh, &config, Some(references), &mut said)?;
        let paper = match experiment.paper.as_ref().and_then(|paper| paper.reference_samples) {
            Some(count) => {
                let row = Row::monte_carlo(width, height, count, seed);
                let builder = row.config.builder(Arc::clone(&scene), Arc::clone(&loaded.bvh));
                let mut pipeline = builder.build().map_err(|source| fault(&row, source))?;
                Some(pipeline.render().map_err(|source| fault(&row, source))?.irradiance.clone())
            }
            None => None,
        };
        let mut gbuffer = GBuffer::default();
        gbuffer::trace(&loaded.bvh, &scene, width, height, &mut gbuffer);
        if let Some(reason) = unlit(&scene, &gbuffer, &reference.irradiance) {
            return Err(AblateError::Unlit { setting: setting.label.clone(), reason });
        }
        let receivers = (0..gbuffer.pixels()).map(|pixel| gbuffer.is_receiver(pixel)).collect();
        Ok(Self { scene, reference, paper, gbuffer, receivers })
    }

    pub(super) fn image<'a>(&'a self, pixels: &'a [Vec3]) -> Result<Image<'a>, AblateError> {
        let (width, height) = (self.reference.width, self.reference.height);
        Ok(Image::new(width, height, pixels)?.with_mask(&self.receivers)?)
    }

    pub(super) fn write_picture(&self, path: &Path, irradiance: &[Vec3]) -> Result<(), AblateError> {
        let picture = picture::image(irradiance, &self.gbuffer.albedo, picture::EXPOSURE);
        Ok(write_png(path, self.gbuffer.width, self.gbuffer.height, &picture)?)
    }

    /// Errors against a reference, and its SSE after division by the reference's peak.
    pub(super) fn errors(
        &self,
        row: &Row,
        irradiance: &[Vec3],
        reference: &[Vec3],
    ) -> Result<(Comparison, f64), AblateError> {
        let errors = compare(self.image(irradiance)?, self.image(reference)?)
            .map_err(|source| AblateError::Compare { row: row.label(), source })?;
        let lit = reference.iter().zip(&self.receivers).filter(|(_, receives)| **receives);
        let peak = f64::from(lit.fold(0.0f32, |peak, (value, _)| peak.max(value.abs().max_element())));
        Ok((errors, errors.sse / (peak * peak)))
    }
}

pub(super) fn fault(row: &Row, source: halflight_cpu::pipeline::PipelineError) -> AblateError {
    AblateError::Pipeline { row: row.label(), source }
}
