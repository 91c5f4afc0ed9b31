// Voxel marching, per ray: from a receiver and a position on the light to visibility
// (halflight-cpu/src/voxel/march.rs).
//@ needs shared/light shared/receiver visibility/voxel_space
//@ reads grid

// Samples per ray; 0 for every voxel that it passes.
override STEPS: u32 = 16u;
// Neighbouring slices before and behind a sample.
override THICKNESS: u32 = 0u;

// Offset of ray origins from surfaces in addition to the bias, relative to the largest coordinate, as on the
// CPU.
const ROUNDING: f32 = 1.0 / 4194304.0;

// True if voxels hide the point at `at` in the unit square of the light from a receiver. Both ends of its
// rays are offset from their surfaces.
fn is_hidden(receiver: Receiver, at: vec2<f32>, end: vec3<f32>) -> bool {
    let range = depth_range(grid[NEAR], grid[FAR], grid[DEEPEST]);
    if range.x >= range.y {
        return false;
    }
    let coordinates = abs(receiver.origin);
    let rounding = max(max(coordinates.x, coordinates.y), coordinates.z) * ROUNDING;
    let bias = BIAS * width_along(receiver.origin, receiver.normal, range) + rounding;
    let start = receiver.origin + receiver.normal * bias;
    // A receiver close to the light's plane must not end up behind it.
    let height = dot3(frame.light_normal, from_light(receiver.origin));
    let clearance = min(bitcast<f32>(grid[LIGHTS + frame.light]), abs(height) * 0.5);
    let lift = select(clearance, -clearance, height < 0.0);
    let light = space.lights[frame.light];
    let stop = light.corner + light.normal * lift + light.u * at.x + light.v * at.y;
    if STEPS == 0u {
        return walk(place(start), stop, range);
    }
    return step_through(place(start), stop, range);
}

// Slice at a depth, with its fraction.
fn slice_at(depth: f32, range: vec2<f32>) -> f32 {
    return clamp((depth - range.x) * density(range), 0.0, f32(BITS - 1u));
}

// True if any voxel of a texel is set between two slices, both included.
fn is_set(texel: u32, low: u32, high: u32) -> bool {
    let first = first_voxel() + texel * texel_words();
    var bits = 0u;
    for (var word = low / 32u; word <= high / 32u; word++) {
        let after = NONE << (max(low, word * 32u) - word * 32u);
        let until = NONE >> (31u - min(high - word * 32u, 31u));
        bits |= grid[first + word] & after & until;
    }
    return bits != 0u;
}

// Tests samples at equal distances; the first is half a distance from the origin.
fn step_through(origin: vec3<f32>, end: vec3<f32>, range: vec2<f32>) -> bool {
    let side = f32(RESOLUTION);
    for (var sample = 0u; sample < STEPS; sample++) {
        let point = origin + (end - origin) * ((f32(sample) + 0.5) / f32(STEPS));
        let at = point.xy * (1.0 / point.z);
        let inside = range.x <= point.z && point.z <= range.y && all(at >= vec2(0.0)) && all(at <= vec2(side));
        if inside {
            let texel = vec2<u32>(min(at, vec2(side - 1.0)));
            let middle = u32(slice_at(point.z, range));
            let low = middle - min(middle, THICKNESS);
            if is_set(texel.y * RESOLUTION + texel.x, low, min(middle + THICKNESS, BITS - 1u)) {
                return true;
            }
        }
    }
    return false;
}

// Tests every voxel that the ray passes: 1 / depth is linear along the image.
fn walk(origin: vec3<f32>, end: vec3<f32>, range: vec2<f32>) -> bool {
    let part = inside_part(origin, end, range);
    if part.x > part.y {
        return false;
    }
    let a = origin + (end - origin) * part.x;
    let b = origin + (end - origin) * part.y;
    let inverse = 1.0 / a.z;
    let change = 1.0 / b.z - inverse;
    let start = a.xy * inverse;
    let goal = b.xy * (1.0 / b.z);
    let last = vec2(f32(RESOLUTION - 1u));
    var texel = vec2<i32>(clamp(start, vec2(0.0), last));
    let last_texel = vec2<i32>(clamp(goal, vec2(0.0), last));
    let ahead = select(vec2(-1), vec2(1), texel < last_texel);
    var border = vec2<f32>(texel) + select(vec2(0.0), vec2(1.0), texel < last_texel);
    var left = abs(last_texel - texel);
    var slice = u32(slice_at(a.z, range));
    loop {
        // Ray parameter at which the next border is crossed.
        let next = select(vec2(1e30), (border - start) / (goal - start), left > vec2(0));
        let along = min(min(next.x, next.y), 1.0);
        let following = u32(slice_at(1.0 / (inverse + along * change), range));
        if is_set(u32(texel.y) * RESOLUTION + u32(texel.x), min(slice, following), max(slice, following)) {
            return true;
        }
        slice = following;
        if left.x + left.y <= 0 {
            return false;
        }
        let axis = select(1u, 0u, next.x <= next.y);
        texel[axis] += ahead[axis];
        border[axis] += f32(ahead[axis]);
        left[axis] -= 1;
    }
    return false;
}

// Ray parameters at which a ray enters and leaves the grid; the second is less than the first where it misses
// the grid.
fn inside_part(origin: vec3<f32>, end: vec3<f32>, range: vec2<f32>) -> vec2<f32> {
    let side = f32(RESOLUTION);
    var first = array(
        origin.z - range.x,
        range.y - origin.z,
        origin.x,
        side * origin.z - origin.x,
        origin.y,
        side * origin.z - origin.y,
    );
    var second =
        array(end.z - range.x, range.y - end.z, end.x, side * end.z - end.x, end.y, side * end.z - end.y);
    var part = vec2(0.0, 1.0);
    for (var plane = 0u; plane < 6u; plane++) {
        let at = first[plane] / (first[plane] - second[plane]);
        if first[plane] < 0.0 && second[plane] < 0.0 {
            return vec2(1.0, 0.0);
        }
        if first[plane] < 0.0 {
            part.x = max(part.x, at);
        }
        if second[plane] < 0.0 {
            part.y = min(part.y, at);
        }
    }
    return part;
}
