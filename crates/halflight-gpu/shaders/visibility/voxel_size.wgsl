// Measures of the voxels.

// Texels a side, slices, and what the origin of a ray is pushed off by, in voxels.
override RESOLUTION: u32 = 128u;
override BITS: u32 = 128u;
override BIAS: f32 = 1.0;
// Triangles of the scene.
override TRIANGLES: u32 = 0u;

// Rows of a band of a large triangle.
const BAND: u32 = 16u;

fn bands() -> u32 {
    return (RESOLUTION + BAND - 1u) / BAND;
}
