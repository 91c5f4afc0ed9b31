// Coordinate system of the voxel grid, as in halflight-cpu/src/voxel/frustum.rs: X, Y and depth are linear in
// a point's world-space position; X / depth and Y / depth are texels, right and down.
//@ needs visibility/voxel_size
//@ reads space

struct Space {
    // Vectors whose products with a point are X, Y and depth.
    across: vec3<f32>,
    // Depth of the deepest corner of a light.
    lights_deepest: f32,
    down: vec3<f32>,
    // Size of a texel at depth 1.
    texel_right: vec3<f32>,
    texel_up: vec3<f32>,
    forward: vec3<f32>,
    lights: array<TurnedLight>,
}

// Light in these coordinates.
struct TurnedLight {
    corner: vec3<f32>,
    u: vec3<f32>,
    v: vec3<f32>,
    normal: vec3<f32>,
}

// Layout of the words before the voxels: the nearest receiver's depth, inverted, the farthest one's, and the
// deepest corner of a triangle; 0 for none. From LIGHTS on one word per light: the distance before its plane
// at which rays end.
const NEAR: u32 = 0u;
const FAR: u32 = 1u;
const DEEPEST: u32 = 2u;
const LIGHTS: u32 = 4u;

fn first_voxel() -> u32 {
    return LIGHTS + frame.lights;
}

// Words of a texel.
fn texel_words() -> u32 {
    return 2u * ((BITS + 63u) / 64u);
}

fn turn(v: vec3<f32>) -> vec3<f32> {
    return vec3(dot3(space.across, v), dot3(space.down, v), dot3(space.forward, v));
}

fn place(point: vec3<f32>) -> vec3<f32> {
    return turn(point - frame.eye);
}

// Depth range of the voxels, from the words before them; empty where the second is not more than the first.
fn depth_range(inverted: u32, farthest: u32, deepest: u32) -> vec2<f32> {
    if inverted == 0u {
        return vec2(0.0);
    }
    var near = bitcast<f32>(~inverted);
    // No receiver lies behind the last corner, whatever its depth.
    var far = min(bitcast<f32>(farthest), bitcast<f32>(deepest));
    if space.lights_deepest > far {
        far = max(far, min(space.lights_deepest, bitcast<f32>(deepest)));
    }
    // Margin for rounding, and for walls that face the camera.
    far *= 1.0001;
    near = clamp(near * 0.9999, far * 1e-5, far * (1.0 - 1.0 / 64.0));
    return vec2(near, far);
}

// Slices per metre.
fn density(range: vec2<f32>) -> f32 {
    return f32(BITS) / (range.y - range.x);
}

// Width of a voxel around a point along a unit vector.
fn width_along(point: vec3<f32>, normal: vec3<f32>, range: vec2<f32>) -> f32 {
    let seen = point - frame.eye;
    let depth = max(dot3(space.forward, seen), range.x);
    let across = abs(dot3(normal, space.texel_right)) + abs(dot3(normal, space.texel_up));
    let along = abs(dot3(normal, seen / depth));
    return across * min(depth, range.y) + along * (range.y - range.x) / f32(BITS);
}
