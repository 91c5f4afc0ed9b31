//! Options of the `voxel` backend.

use serde::{Deserialize, Serialize};

/// Method by which a ray traverses the grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "name", rename_all = "kebab-case")]
pub enum Traversal {
    /// Samples at equal distances between receiver and light, each of which tests several slices (Nichols10
    /// §3.3.1). The paper does not tell their number.
    Steps {
        /// Samples per ray, 1 to 1,024.
        count: u32,
    },
    /// Every voxel that the ray passes, as the paper wished for (§3.3.1: "ideally, we would perform a 3D
    /// DDA").
    Dda,
}

impl Default for Traversal {
    /// Returns 16 steps. Exact traversal meets every voxel that geometry touches and is darker for it: on the
    /// bundled atrium and hairball, 16 steps have fewer wrong pixels, in less time.
    fn default() -> Self {
        Self::Steps { count: 16 }
    }
}

/// Constants of voxel marching (Nichols10 §3.3, §4.2, §4.3).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct VoxelConfig {
    /// Texels per side of the square grid, 32 to 1,024: 128 (Nichols10 §4.2, Fig. 11).
    pub resolution: u32,
    /// Slices, 32 to 512: 128, the four 32-bit channels of a texture (§3.3, §4.2).
    pub depth_bits: u32,
    /// Method of traversal.
    pub traversal: Traversal,
    /// Neighbouring slices before and behind a sample that are tested with it, 0 to 64. For
    /// [`Traversal::Steps`] only, since an exact traversal skips none. The paper tests "multiple bits" to
    /// thicken rays (§3.3.1; no number there) in a grid that graphics hardware rasterized at texel centres;
    /// this grid is conservative and thick enough: 0.
    pub thickness: u32,
    /// Offset of a ray's origin from its surface along the normal (§4.3; no number there), 0 to 64 voxels.
    /// The unit is the width along the normal of the voxel around the receiver: at 1 the origin has just left
    /// all voxels that the receiver's tangent plane touches. The other end is offset from the light's plane
    /// in the same way, so that the light's mounting surface does not stop rays.
    pub bias: f32,
}

impl Default for VoxelConfig {
    fn default() -> Self {
        Self { resolution: 128, depth_bits: 128, traversal: Traversal::default(), thickness: 0, bias: 1.0 }
    }
}

/// Option value out of range.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum VoxelError {
    /// Texels per side.
    #[error("voxel resolution {0} is out of range: a grid has 32 to 1024 texels a side")]
    Resolution(u32),
    /// Slices.
    #[error("{0} depth bits are out of range: a grid has 32 to 512 slices")]
    DepthBits(u32),
    /// Samples per ray.
    #[error("{0} steps are out of range: a ray has 1 to 1024")]
    Steps(u32),
    /// Neighbouring slices.
    #[error("a thickness of {0} voxels is out of range: 0 to 64 neighbouring slices are tested")]
    Thickness(u32),
    /// Bias.
    #[error("a bias of {0} voxels is out of range: it must be 0 to 64")]
    Bias(f32),
}

impl VoxelConfig {
    /// Checks every constant.
    ///
    /// # Errors
    /// An error for the first option that is out of range.
    pub fn validate(&self) -> Result<(), VoxelError> {
        if !(32..=1024).contains(&self.resolution) {
            return Err(VoxelError::Resolution(self.resolution));
        }
        if !(32..=512).contains(&self.depth_bits) {
            return Err(VoxelError::DepthBits(self.depth_bits));
        }
        match self.traversal {
            Traversal::Steps { count } if !(1..=1024).contains(&count) => {
                return Err(VoxelError::Steps(count));
            }
            _ => {}
        }
        if self.thickness > 64 {
            return Err(VoxelError::Thickness(self.thickness));
        }
        // NaN must fail as well.
        if !(0.0..=64.0).contains(&self.bias) {
            return Err(VoxelError::Bias(self.bias));
        }
        Ok(())
    }
}
