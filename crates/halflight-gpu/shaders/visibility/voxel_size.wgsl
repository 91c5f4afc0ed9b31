// Dimensions of the voxel grid.

// Texels per side, slices, and the offset of a ray's origin in voxels.
override RESOLUTION: u32 = 128u;
override BITS: u32 = 128u;
override BIAS: f32 = 1.0;
// Number of triangles of the scene that have no alpha mask.
override TRIANGLES: u32 = 0u;

// Rows of a band of a large triangle.
const BAND: u32 = 16u;

fn bands() -> u32 {
    return (RESOLUTION + BAND - 1u) / BAND;
}
