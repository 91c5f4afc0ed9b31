//! The three stage traits: refiner, visibility backend and upsampler.
//!
//! All are object-safe and work on batches. `&mut self` is for buffers that are kept from frame to frame; a stage's answer
//! depends on its configuration and arguments alone.

use crate::certificate::{Certificate, Region};
use crate::fragment::Fragments;
use crate::frame::Frame;
use crate::light::AreaLight;
use crate::mask::MaskBatch;
use crate::pattern::Pattern;
use crate::pyramid::MAX_LEVEL;
use crate::stats::{CertificateCounts, LevelWork, VisibilityStats};
use crate::values::Values;

/// A combination of stages that cannot work.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{stage} cannot answer {pattern:?} patterns: {reason}")]
#[non_exhaustive]
pub struct Unsupported {
    /// Name of the stage that refuses.
    pub stage: String,
    /// Pattern that it was asked for.
    pub pattern: Pattern,
    /// Why, and what would work.
    pub reason: String,
}

impl Unsupported {
    /// A refusal by `stage` to answer `pattern`.
    pub fn new(stage: impl Into<String>, pattern: Pattern, reason: impl Into<String>) -> Self {
        Self { stage: stage.into(), pattern, reason: reason.into() }
    }
}

/// Light that a stage cannot work with.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{stage} has no answers for {light}: {reason}")]
#[non_exhaustive]
pub struct UnsupportedLight {
    /// Name of the stage that refuses.
    pub stage: String,
    /// Kind of light that it was asked for, in the plural.
    pub light: String,
    /// Why, and what would work.
    pub reason: String,
}

impl UnsupportedLight {
    /// A refusal by `stage` to work with lights of a kind, named in the plural.
    pub fn new(stage: impl Into<String>, light: impl Into<String>, reason: impl Into<String>) -> Self {
        Self { stage: stage.into(), light: light.into(), reason: reason.into() }
    }
}

/// Results of a refiner beside the fragments, for one light. Refiners fill in what they know over the default.
#[derive(Clone, Copy, Debug, Default)]
pub struct RefineOutput<'a> {
    /// Expected squared error of the light's irradiance, by luminance, summed over the image, (W/m²)²; none from refiners that
    /// do not aim at an error.
    pub expected_error: Option<f64>,
    /// Visible fractions of the first samples, as the ratio estimator gives them, [`NO_VALUE`](crate::values::NO_VALUE) where a
    /// sample has none; empty where the refiner has computed none. They need not be computed again. Of textured lights, those of
    /// red, green and blue as a vector.
    pub fractions: &'a [f32],
    /// Visible fractions of red, green and blue of the first samples, for a textured light; otherwise empty.
    pub colours: &'a [[f32; 3]],
    /// Pixels by what was certified of their cells, from refiners that ask for certificates.
    pub certified: CertificateCounts,
    /// Work of each level, 0 first, from refiners that work level by level; otherwise empty.
    pub levels: &'a [LevelWork],
}

/// Decides which fragments an image is made of, asking for visibility as often as it needs.
pub trait Refiner: Send {
    /// Fills `fragments`, which has been reset, for one light. Every receiver pixel must end up in exactly one cell.
    fn refine(
        &mut self,
        frame: &Frame,
        light: u32,
        visibility: &mut dyn Visibility,
        fragments: &mut Fragments,
    ) -> RefineOutput<'_>;

    /// Returns the patterns that the refiner will ask for when a full mask has pattern `full`, so that a backend can refuse when
    /// the pipeline is built instead of in the middle of a frame.
    fn patterns(&self, full: Pattern) -> Vec<Pattern> {
        vec![full]
    }

    /// Returns the coarsest level of the discontinuity pyramid that the refiner reads; 0 for none, and none is built.
    fn coarsest_level(&self) -> u8 {
        MAX_LEVEL
    }

    /// Returns the bytes held in the stage's own buffers.
    fn bytes(&self) -> usize {
        0
    }
}

/// Answers which light samples receivers see.
pub trait Visibility: Send {
    /// Writes `visible` for every wanted sample of every query. A sample is visible when the open segment from the query's
    /// origin to the sample meets no triangle without an alpha mask; who asks takes out afterwards what triangles with one hide. Samples below a horizon have been taken out of `wanted` beforehand.
    fn masks(&mut self, frame: &Frame, batch: &mut MaskBatch);

    /// Checks that the backend can answer queries with this pattern.
    ///
    /// # Errors
    /// A refusal that says why.
    fn supports(&self, _pattern: Pattern) -> Result<(), Unsupported> {
        Ok(())
    }

    /// Checks that the backend can answer queries about this light. By default it cannot where the frame of the light's samples depends on the
    /// receiver ([`AreaLight::seen_from`]), as that of a sphere does.
    ///
    /// # Errors
    /// A refusal that says why, and what works instead.
    fn supports_light(&self, light: &AreaLight) -> Result<(), UnsupportedLight> {
        if light.as_sphere().is_none() {
            return Ok(());
        }
        let reason = "every receiver has a frame of light samples of its own; use bvh, beam or auto";
        Err(UnsupportedLight::new("the visibility backend", "sphere lights", reason))
    }

    /// Writes what it can certify of the visible fraction in regions of receivers, one [`Certificate`] a region, as if there were no
    /// triangles with alpha masks. A backend that does
    /// not look at triangles, or only at some, certifies nothing.
    fn certify(
        &mut self,
        _frame: &Frame,
        _light: u32,
        regions: &[Region],
        certificates: &mut Vec<Certificate>,
    ) {
        certificates.clear();
        certificates.resize(regions.len(), Certificate::Open);
    }

    /// Does the work that is due once a frame, before the first batch (voxels, triangle bins).
    fn prepare(&mut self, _frame: &Frame) {}

    /// Returns counts of how masks were computed since the last [`prepare`](Self::prepare).
    fn stats(&self) -> VisibilityStats {
        VisibilityStats::default()
    }

    /// Returns the bytes held in the stage's own buffers.
    fn bytes(&self) -> usize {
        0
    }
}

/// Turns values at samples into values at pixels.
pub trait Upsampler: Send {
    /// Writes one channel: `out`, one value a pixel, from `values`, one a sample of `fragments` or
    /// [`NO_VALUE`](crate::values::NO_VALUE). Every element of `out` is written; pixels outside all cells get 0.
    fn upsample(&mut self, frame: &Frame, fragments: &Fragments, values: &[f32], out: &mut [f32]);

    /// Writes all channels of `values`, into `out` one after another, each as [`upsample`](Self::upsample) would. By default
    /// that is called for each; an upsampler may instead compute weights once for all.
    fn upsample_channels(&mut self, frame: &Frame, fragments: &Fragments, values: &Values, out: &mut [f32]) {
        let pixels = frame.gbuffer.pixels().max(1);
        for (channel, out) in out.chunks_mut(pixels).enumerate() {
            self.upsample(frame, fragments, values.channel(channel), out);
        }
    }

    /// Returns the bytes held in the stage's own buffers.
    fn bytes(&self) -> usize {
        0
    }
}
