//! Frames in progress: the data that every stage may read.

use serde::{Deserialize, Serialize};

use crate::gbuffer::GBuffer;
use crate::hash;
use crate::light::AreaLight;
use crate::light_texture::PlacedTexture;
use crate::pattern::{Pattern, PatternError, PatternKind};
use crate::pyramid::Pyramid;
use crate::scene::Scene;

/// Which receivers use the same light-sample positions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sharing {
    /// Every receiver has positions of its own.
    Receiver,
    /// All receivers of one fragment share theirs.
    Fragment,
    /// All receivers of a frame share theirs.
    Frame,
}

/// How the light is sampled: how many samples, placed how, shared by whom.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct LightSampling {
    /// Samples of a full mask.
    pub count: u32,
    /// Placement inside the strata.
    pub kind: PatternKind,
    /// Who shares positions, for refiners that leave the choice.
    pub sharing: Sharing,
}

impl Default for LightSampling {
    fn default() -> Self {
        Self { count: 64, kind: PatternKind::Jittered, sharing: Sharing::Fragment }
    }
}

impl LightSampling {
    /// The pattern of a full mask.
    ///
    /// # Errors
    /// The count is outside what masks can hold.
    pub fn pattern(&self) -> Result<Pattern, PatternError> {
        Pattern::with_count(self.kind, self.count as usize)
    }
}

/// A frame in progress: all that refiners, backends and upsamplers may read.
#[derive(Clone, Copy, Debug)]
pub struct Frame<'a> {
    /// Geometry, lights and camera.
    pub scene: &'a Scene,
    /// Surfaces that the pixels see.
    pub gbuffer: &'a GBuffer,
    /// Discontinuities of the surfaces.
    pub pyramid: &'a Pyramid,
    /// The pattern of a full mask.
    pub pattern: Pattern,
    /// Who shares light-sample positions.
    pub sharing: Sharing,
    /// Number of the frame in its sequence.
    pub index: u32,
    /// Seed of all randomness.
    pub seed: u32,
}

impl Frame<'_> {
    /// The light with this index. Indices come from the pipeline, which knows how many there are.
    #[inline]
    pub fn light(&self, index: u32) -> &AreaLight {
        &self.scene.lights[index as usize]
    }

    /// Texture of the light with this index; none for a uniform light.
    #[inline]
    pub fn light_texture(&self, index: u32) -> Option<PlacedTexture<'_>> {
        self.scene.light_texture(self.light(index))
    }

    /// Pattern key for the receiver at `pixel` in the fragment whose own key number is `fragment`, by the frame's
    /// sharing rule.
    #[inline]
    pub fn key(&self, light: u32, fragment: u32, pixel: u32) -> u32 {
        let place = match self.sharing {
            Sharing::Receiver => pixel,
            Sharing::Fragment => fragment,
            Sharing::Frame => 0,
        };
        hash::pattern_key(place, light, self.index, self.seed)
    }

    /// Pattern key that all receivers of the frame share.
    #[inline]
    pub fn shared_key(&self, light: u32) -> u32 {
        hash::pattern_key(0, light, self.index, self.seed)
    }
}
