//! Nichols10's multiresolution gather without visibility (§3.2): fragments by depth and normals alone, light samples that nothing hides.

use halflight_core::frame::Frame;
use halflight_core::mask::MaskBatch;
use halflight_core::stages::Visibility;
use halflight_cpu::refine::{GeometryThresholds, NicholsConfig};
use serde::{Deserialize, Serialize};

/// Constants of the gather without visibility.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct UnshadowedConfig {
    /// Light samples: 256 (§3.2.1).
    pub samples: u32,
    /// Level of the coarsest fragments.
    pub coarsest_level: u8,
    /// Thresholds at which geometry splits a fragment (§3.2).
    pub geometry: GeometryThresholds,
}

impl Default for UnshadowedConfig {
    fn default() -> Self {
        let NicholsConfig { coarsest_level, geometry, .. } = NicholsConfig::default();
        Self { samples: 256, coarsest_level, geometry }
    }
}

impl UnshadowedConfig {
    /// Returns the refiner's constants.
    pub(super) fn refiner(&self) -> NicholsConfig {
        NicholsConfig {
            coarsest_level: self.coarsest_level,
            geometry: self.geometry,
            ..NicholsConfig::default()
        }
    }
}

/// Backend that lets everything be seen.
pub(super) struct Open;

impl Visibility for Open {
    fn masks(&mut self, _frame: &Frame, batch: &mut MaskBatch) {
        let parts = batch.parts();
        parts.visible.copy_from_slice(parts.wanted);
    }
}
