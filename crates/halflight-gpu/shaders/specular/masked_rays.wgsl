// Shadow rays of lobes through the BVH and through that of triangles with alpha masks, per ray.
//@ needs shared/solid visibility/traversal visibility/triangle

// True if the open segment between two points meets a triangle, in a solid texel where it has an alpha mask.
fn occluded(origin: vec3<f32>, end: vec3<f32>) -> bool {
    return traverse(0u, origin, end) || traverse(masked.root, origin, end);
}

fn stops(triangle: u32, origin: vec3<f32>, end: vec3<f32>, d: vec3<f32>) -> bool {
    return meets(triangle, origin, end, d) && (triangle < masked.first || is_solid(triangle, origin, d));
}
