// Shadow rays through the BVH of triangles with alpha masks, per ray.
//@ needs shared/solid visibility/traversal visibility/triangle

// True if the open segment between two points meets a triangle with an alpha mask in a solid texel.
fn occluded_solidly(origin: vec3<f32>, end: vec3<f32>) -> bool {
    return traverse(masked.root, origin, end);
}

fn stops(triangle: u32, origin: vec3<f32>, end: vec3<f32>, d: vec3<f32>) -> bool {
    return meets(triangle, origin, end, d) && is_solid(triangle, origin, d);
}
