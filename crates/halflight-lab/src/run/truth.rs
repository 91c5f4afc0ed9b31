//! References of a setting, and the pixels that they are compared at.

use std::path::Path;

use anyhow::{Context as _, Result, bail};
use glam::Vec3;
use halflight_core::gbuffer::GBuffer;
use halflight_core::scene::Scene;
use halflight_cpu::prepared::PreparedScene;
use halflight_image::picture;
use halflight_metrics::{Comparison, Image, compare};

use super::loaded::Loaded;
use super::progress::Progress;
use crate::experiment::Experiment;
use crate::experiment::plan::{Row, Setting};
use crate::reference::unlit::unlit;
use crate::reference::{Reference, ReferenceConfig, receivers, reference, seen};

/// Reference of a setting, with the surfaces that its pixels see.
pub(super) struct Truth {
    pub(super) scene: PreparedScene,
    pub(super) reference: Reference,
    /// Image of the kind that papers take for a reference.
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
    ) -> Result<Self> {
        let scene = loaded.lit(setting.light_scale)?;
        let config = experiment.reference_of(setting);
        let ReferenceConfig { width, height, seed, .. } = config;
        let mut said = |done: u32, all: u32| {
            progress.now(format!("{}: reference, {done} of {all} samples a pixel", setting.label));
        };
        let reference = reference(&scene, &config, Some(references), &mut said)?;
        let paper = match experiment.paper.as_ref().and_then(|paper| paper.reference_samples) {
            Some(count) => {
                let row = Row::monte_carlo(width, height, count, seed);
                let mut pipeline = row.builder(&scene).build().with_context(|| row.named())?;
                Some(pipeline.render().with_context(|| row.named())?.irradiance.clone())
            }
            None => None,
        };
        let gbuffer = seen(&scene, [width, height]);
        check_light(&setting.label, scene.scene(), &gbuffer, &reference.irradiance)?;
        let receivers = receivers(&gbuffer);
        Ok(Self { scene, reference, paper, gbuffer, receivers })
    }

    /// Returns pixels as an image to compare, with the visible fractions of the reference.
    pub(super) fn image<'a>(&'a self, pixels: &'a [Vec3]) -> Result<Image<'a>> {
        let Reference { width, height, visibility, .. } = &self.reference;
        let image = Image::new(*width, *height, pixels)?;
        Ok(image.with_mask(&self.receivers)?.with_visible_fractions(visibility)?)
    }

    /// Returns the tone-mapped picture of an image.
    pub(super) fn picture(&self, irradiance: &[Vec3]) -> Vec<[u8; 3]> {
        picture::image(irradiance, &self.gbuffer.albedo, picture::EXPOSURE)
    }

    /// Returns errors against a reference, and the SSE after division by the reference's peak.
    pub(super) fn errors(
        &self,
        row: &Row,
        irradiance: &[Vec3],
        reference: &[Vec3],
    ) -> Result<(Comparison, f64)> {
        let errors = compare(self.image(irradiance)?, self.image(reference)?).with_context(|| row.named())?;
        let lit = reference.iter().zip(&self.receivers).filter(|(_, receives)| **receives);
        let peak = f64::from(lit.fold(0.0f32, |peak, (value, _)| peak.max(value.abs().max_element())));
        Ok((errors, errors.sse / (peak * peak)))
    }
}

/// Refuses a reference that no light reaches.
pub(super) fn check_light(setting: &str, scene: &Scene, gbuffer: &GBuffer, reference: &[Vec3]) -> Result<()> {
    if let Some(reason) = unlit(scene, gbuffer, reference) {
        bail!("{setting}: {reason}; errors relative to a black reference are undefined");
    }
    Ok(())
}
