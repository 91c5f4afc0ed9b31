//! Emitters that cannot be lights.

use glam::Vec3;
use halflight_core::light::{LightError, PolygonError};
use halflight_core::scene::MAX_COORDINATE;

use crate::emission::Emission;

/// Reason why an emitter cannot be a light. Its text continues "the emitter ".
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub(super) enum Refusal {
    #[error("emits a texture (map_Ke), expected one Ke; textured lights are [[light]] with the key texture")]
    Textured,
    #[error("is not flat; give its flat parts materials of their own, or add a [[light]] before it")]
    Curved,
    #[error("has a hole or touches itself; give its convex parts materials of their own")]
    Holes,
    #[error("has faces that overlap; remove one of them")]
    Overlap,
    #[error("has an unfit outline ({0}); give its convex parts materials of their own, or add a [[light]]")]
    Polygon(PolygonError),
    #[error("is too thin; widen it")]
    Thin,
    #[error("lies {MAX_COORDINATE:e} m or more from the origin along an axis; bring it nearer")]
    TooFar,
}

impl From<LightError> for Refusal {
    fn from(fault: LightError) -> Self {
        if let LightError::TooFar { .. } = fault { Self::TooFar } else { Self::Thin }
    }
}

/// Refusals of the emitters of a material.
#[derive(Default)]
pub(super) struct Refusals {
    /// First refusal, and a corner of its emitter.
    first: Option<(Refusal, Vec3)>,
    refused: usize,
    emitters: usize,
}

impl Refusals {
    /// Counts an emitter that became a light.
    pub(super) fn count(&mut self) {
        self.emitters += 1;
    }

    /// Adds an emitter that cannot be a light.
    pub(super) fn add(&mut self, refusal: Refusal, corner: Vec3) {
        self.emitters += 1;
        self.refused += 1;
        self.first.get_or_insert((refusal, corner));
    }

    /// Message about all refusals, if there are any: file, line, material, number, place and reason.
    pub(super) fn message(&self, emission: &Emission, source: &str) -> Option<String> {
        let (refusal, corner) = self.first?;
        let (library, line, material) = (emission.file.display(), emission.line, &emission.material);
        let Self { refused, emitters, .. } = self;
        Some(format!(
            "{library}:{line}: {refused} of {emitters} emitters of material `{material}` in `{source}` cannot be lights: \
             the first, at {corner}, {refusal}"
        ))
    }
}
