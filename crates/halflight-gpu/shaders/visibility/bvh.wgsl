// Shadow rays through the BVH, per ray.
//
// The interface of a visibility module is `occluded`: true if the open segment between two points meets a
// triangle without an alpha mask. Their BVH has its root in the first node (visibility/traversal.wgsl).
//@ needs visibility/traversal visibility/triangle

fn occluded(origin: vec3<f32>, end: vec3<f32>) -> bool {
    return traverse(0u, origin, end);
}

fn stops(triangle: u32, origin: vec3<f32>, end: vec3<f32>, d: vec3<f32>) -> bool {
    return meets(triangle, origin, end, d);
}
