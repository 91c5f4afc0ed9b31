// Triangles with alpha masks, which come last in `triangles`, in a BVH of their own. The twins are in masked.rs.
//@ reads masked

struct Masked {
    // Root of their BVH.
    root: u32,
    // Index of the first of them in `triangles`.
    first: u32,
    // Triangles from the first on.
    triangles: array<MaskedTriangle>,
}

struct MaskedTriangle {
    // Texture coordinates of the corners, none below 0.
    a: vec2<f32>,
    b: vec2<f32>,
    c: vec2<f32>,
    // Width and height of the mask.
    size: vec2<u32>,
    // First word of the mask.
    texels: u32,
}
